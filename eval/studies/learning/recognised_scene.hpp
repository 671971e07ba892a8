#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>

namespace carillon::eval::studies {

/// An object that was recognised by its sound, as an object of a scene.
struct RecognisedObject {
  std::string name;      ///< in its dataset; the object is `recognised-NAME`
  std::string entry;     ///< YAML on one line: shape or mesh, with its parameters
  std::string material;  ///< a preset's name, or its values
};

/// The object of a dataset that stands for a class.
/// @param dataset   folder with dataset.json
/// @param column    of the class: shape or family; of a family its first object
/// @throws InputError  no such object, or none that could be made again elsewhere
/// @throws FileError   no dataset.json that can be read
RecognisedObject object_of_class(const std::filesystem::path& dataset, const std::string& column,
                                 const std::string& name);

/// A material as scenes name it: a preset by its name, a dataset's own by its values.
/// @throws InputError  the dataset has no such material
std::string material_of_class(const std::filesystem::path& dataset, const std::string& name);

/// A scene's text with one object more, at a place: an entry of `objects` and one of
/// `motion.bodies`. Comments and all else stay as they are.
/// @param text   YAML of a configuration with both lists
/// @param place  of the centre of the object's box [m], in the world
/// @throws InputError  no such lists, not YAML, or the object is there already; names the file
std::string with_object(const std::string& text, const std::string& file,
                        const RecognisedObject& object, const Eigen::Vector3d& place);

}  // namespace carillon::eval::studies

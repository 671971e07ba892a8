#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/trace.hpp"
#include "scene/live/instrument.hpp"
#include "scene/scene.hpp"

namespace carillon::scene::live {

/// How an effect of a scene is heard while it is played.
struct LiveEffect {
  std::string name;
  bool heard = false;
  std::string why;
};

/// Every effect that the scene runs, and whether it is heard live. What is not costs nothing.
std::vector<LiveEffect> live_effects(const Scene& scene);

/// Makes objects playable as a scene has them: damping, pressure at the listeners, supports, a
/// place to strike.
class LiveStage {
 public:
  /// @param supports  the list under supports.contacts as YAML, resolved in SI units; "": none
  /// @param seed      of the places struck, and of what supports draw
  /// @param cache     as SoundChain
  /// @throws ConfigError, InputError
  LiveStage(const Scene& scene, const std::string& supports, std::uint64_t seed,
            std::filesystem::path cache);

  /// @param name       of the object; one of a kind
  /// @param shape      what it is in a material and a size
  /// @param materials  one per region
  /// @param places     spread over it, for keys; 0: none
  /// @throws InputError  as effects do
  LiveObject make(const std::string& name, const std::string& shape,
                  std::shared_ptr<const solvers::modes::Modes> modes,
                  const std::vector<synth::material::Material>& materials,
                  std::size_t places) const;

 private:
  /// A support, and a scene of it alone.
  struct Hold {
    std::string kind;
    double coefficient;  ///< [s/m]
    double resistance;   ///< of each place [N s/m]
    Scene scene;
  };
  const Scene& scene_;
  std::vector<Hold> holds_;
  std::uint64_t seed_;
  std::filesystem::path cache_;
};

/// The list under supports.contacts of a configuration that has been resolved, as YAML; "": none.
std::string contacts_of(const std::string& resolved);

}  // namespace carillon::scene::live

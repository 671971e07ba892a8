#pragma once

#include <string>

namespace carillon::dataset::exporters {

/// A licence as the header of a card on the Hugging Face Hub says it.
struct HubLicense {
  std::string id;    ///< one of the Hub's list; `other`: not on it; `unknown`: none was given
  std::string name;  ///< of `other`: lower case, without blanks
  std::string link;  ///< of `other`, where the licence was given as an address
};

/// @param license  an SPDX identifier, an address or any other text; "": none
HubLicense hub_license(const std::string& license);

}  // namespace carillon::dataset::exporters

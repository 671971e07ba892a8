#pragma once

namespace carillon::cli {

/// The version, and after a plus sign where in git the source stands that is no release itself:
/// commits since that release, the commit, and `dirty` where files differ from it. Datasets and
/// `--version` name it; keys of what is kept have CARILLON_VERSION alone, so that a commit does not
/// make all of it anew.
/// @return for example `0.1.0`, `0.1.0+67.g16a2a74` or `0.1.0+g16a2a74.dirty`
const char* revision();

}  // namespace carillon::cli

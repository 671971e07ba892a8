#pragma once

namespace carillon::core {

/// The version without where in git it stands: what keys of kept results name, so that a commit
/// does not make all of them anew.
/// @return for example `0.1.0`
const char* version();

/// The version, and after a plus sign where in git the source stands that is no release itself:
/// commits since that release (all, before it), the commit, and `dirty` where files differ from it.
/// Datasets and
/// `--version` name it.
/// @return for example `0.1.0`, `0.1.0+67.g16a2a7408` or `0.1.0+67.g16a2a7408.dirty`
const char* revision();

}  // namespace carillon::core

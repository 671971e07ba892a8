"""The parts of scripts/nightly; docs/nightly.md says what they do together."""

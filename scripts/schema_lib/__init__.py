"""The parts of scripts/make_schema, which tests/end_to_end/schema.py uses too."""

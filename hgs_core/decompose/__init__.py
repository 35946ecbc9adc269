"""Which pixels and which points move."""

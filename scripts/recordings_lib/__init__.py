"""Partials of recordings by means of their own, and what ./scripts/check_recordings makes of them."""

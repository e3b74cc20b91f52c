"""Pictures of motions: the playback page in the browser."""

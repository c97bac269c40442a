"""What a fixture file may say, and what it means: the only room that knows pydantic."""

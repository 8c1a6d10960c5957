"""Recordings whose messages were changed behind the writers' back, as other people's recorders write them."""

import sqlite3
from collections.abc import Callable
from pathlib import Path


def edited(folder: Path, statement: str, *values: object) -> Path:
    """A db3 recording, its only database changed by a statement."""
    (file,) = folder.glob("*.db3")
    with sqlite3.connect(file) as database:
        database.execute(statement, values)
    database.close()
    return folder


def lengthened(folder: Path, more: int) -> Path:
    """A db3 recording with so many zeros behind each message."""
    (file,) = folder.glob("*.db3")
    with sqlite3.connect(file) as database:
        rows = database.execute("SELECT id, data FROM messages").fetchall()
        database.executemany(
            "UPDATE messages SET data = ? WHERE id = ?", [(data + bytes(more), key) for key, data in rows]
        )
    database.close()
    return folder


def redefined(folder: Path, kind: str, change: Callable[[str], str]) -> Path:
    """A db3 recording in which the definition of a type is another text."""
    (file,) = folder.glob("*.db3")
    with sqlite3.connect(file) as database:
        (text,) = database.execute(
            "SELECT encoded_message_definition FROM message_definitions WHERE topic_type = ?", (kind,)
        ).fetchone()
    database.close()
    return edited(
        folder,
        "UPDATE message_definitions SET encoded_message_definition = ? WHERE topic_type = ?",
        change(text),
        kind,
    )

"""The contacts of a BatchScene."""

from __future__ import annotations

from ._probe import AnswerLists


class BatchContacts(AnswerLists):
    """The contacts of each environment of a BatchScene, an array of `softcd.contact_dtype` each, part of `all`."""

    def __repr__(self) -> str:
        return f"<softcd.BatchContacts, {len(self.all)} contacts in {len(self)} environments>"

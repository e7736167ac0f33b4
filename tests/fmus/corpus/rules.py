"""The rules of all chapters."""

from corpus import chapter_03, chapter_04, chapter_05, chapter_07, chapter_08, chapter_09, chapter_10, chapter_11

RULES = [
    case
    for chapter in (chapter_03, chapter_04, chapter_05, chapter_07, chapter_08, chapter_09, chapter_10, chapter_11)
    for case in chapter.RULES
]

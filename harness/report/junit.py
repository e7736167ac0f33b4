"""Results as JUnit XML, with the elements and attributes that Jenkins, GitLab and pytest have in common."""

import re
from collections.abc import Mapping
from datetime import UTC, datetime
from xml.etree import ElementTree

_NOT_IN_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML 1.0 has no form for, escaped or not."""


def junit_xml(suites: Mapping[str, Mapping[str, str]]) -> str:
    """Return suites of test cases as a file.

    Args:
        suites: Name of a suite → name of a case → sentence on its failure; empty for a case that passed.
    """
    root = ElementTree.Element("testsuites")
    now = datetime.now(UTC).isoformat(timespec="seconds")
    for suite, cases in suites.items():
        counts = {"tests": str(len(cases)), "failures": str(sum(map(bool, cases.values()))), "errors": "0"}
        element = ElementTree.SubElement(root, "testsuite", {"name": _legal(suite), **counts, "timestamp": now})
        for case, sentence in cases.items():
            names = {"classname": _legal(suite), "name": _legal(case)}
            result = ElementTree.SubElement(element, "testcase", names)
            if sentence:
                ElementTree.SubElement(result, "failure", message=_legal(sentence)).text = _legal(sentence)
    ElementTree.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ElementTree.tostring(root, encoding="unicode")}\n'


def _legal(text: str) -> str:
    return _NOT_IN_XML.sub(lambda found: f"#x{ord(found[0]):02X}", text)

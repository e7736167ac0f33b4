"""Results as JUnit XML, with the elements and attributes that Jenkins, GitLab and pytest have in common."""

from collections.abc import Mapping
from datetime import UTC, datetime
from xml.etree import ElementTree

from railgrip.base.names import xml_text


def junit_xml(suites: Mapping[str, Mapping[str, str]]) -> str:
    """Return suites of test cases as a file.

    Args:
        suites: Name of a suite → name of a case → sentence on its failure; empty for a case that passed.
    """
    root = ElementTree.Element("testsuites")
    now = datetime.now(UTC).isoformat(timespec="seconds")
    for suite, cases in suites.items():
        counts = {"tests": str(len(cases)), "failures": str(sum(map(bool, cases.values()))), "errors": "0"}
        element = ElementTree.SubElement(root, "testsuite", {"name": xml_text(suite), **counts, "timestamp": now})
        for case, sentence in cases.items():
            names = {"classname": xml_text(suite), "name": xml_text(case)}
            result = ElementTree.SubElement(element, "testcase", names)
            if sentence:
                ElementTree.SubElement(result, "failure", message=xml_text(sentence)).text = xml_text(sentence)
    ElementTree.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ElementTree.tostring(root, encoding="unicode")}\n'

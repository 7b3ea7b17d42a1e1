"""The outcome as JUnit XML for CI: a suite per scene, a case per contestant, a failure if it is worse."""

from collections.abc import Sequence
from xml.etree import ElementTree

from tumble.compare.check.changes import FAILING, Outcome
from tumble.compare.check.words import by_cell, rerun, sentence
from tumble.compare.run.status import described
from tumble.scenarios.format import visible


def junit(outcome: Outcome, against: Sequence[str]) -> str:
    """Return the outcome of a check as JUnit XML.

    Parameters
    ----------
    outcome : what changed
    against : the options that name baseline and tolerances in the command that reruns a cell

    Returns
    -------
    the XML: a suite per scene, a case per contestant
    """
    changes = by_cell(outcome.changes)
    cells = outcome.candidate.cells.to_dict("records")
    statuses = {(row["scene"], row["engine"], row["method"]): described(row["status"], row["why"]) for row in cells}
    top = ElementTree.Element("testsuites", name="tumble check")
    for scene in dict.fromkeys(key[0] for key in (*changes, *statuses)):
        suite = ElementTree.SubElement(top, "testsuite", name=visible(scene))
        for key in dict.fromkeys(key for key in (*statuses, *changes) if key[0] == scene):
            name = f"{key[1]}:{key[2]}".strip(":") or "scene"
            case = ElementTree.SubElement(suite, "testcase", classname=visible(scene), name=visible(name))
            if key in changes:
                first, text = changes[key][0], "\n".join(visible(sentence(change)) for change in changes[key])
                again = f"{text}\n{visible(rerun(outcome.candidate, first, against))}\n"
                if first.verdict in FAILING:
                    ElementTree.SubElement(
                        case, "failure", message=text.partition("\n")[0], type=first.verdict
                    ).text = again
                else:
                    ElementTree.SubElement(case, "system-out").text = again
            elif (status := statuses[key]).startswith(("skipped", "missing")):
                ElementTree.SubElement(case, "skipped", message=visible(status))
    for suite in (*top, top):
        suite.set("tests", str(len(suite.findall(".//testcase"))))
        suite.set("failures", str(len(suite.findall(".//failure"))))
        suite.set("skipped", str(len(suite.findall(".//skipped"))))
        suite.set("errors", "0")
    ElementTree.indent(top)
    return f'<?xml version="1.0" encoding="utf-8"?>\n{ElementTree.tostring(top, encoding="unicode")}\n'

"""What `tumble grade` prints of one file: its poses, then its readings of a sensor."""

from collections.abc import Iterator

from rich.console import RenderableType
from rich.constrain import Constrain
from rich.text import Text

from tumble.compare.grade.file_grade import FileGrade
from tumble.reports.grade import grade_text
from tumble.reports.terminal import LIST_WIDTH, plain


def file_text(found: FileGrade) -> Iterator[RenderableType]:
    """Yield what `tumble grade` prints of a file: the headlines, then the poses, then the readings.

    Parameters
    ----------
    found : the grades of the file

    Returns
    -------
    pieces of text, and tables
    """
    details: list[Iterator[RenderableType]] = []
    if found.pose:
        details.append(grade_text(found.pose))
        yield next(details[0])
    if found.sensor:
        from tumble.reports.sensor_grade import sensor_headline, sensor_text  # most files have no readings

        yield Constrain(plain(sensor_headline(found.sensor)), LIST_WIDTH)
        yield Text()
        details.append(sensor_text(found.sensor))
    for number, pieces in enumerate(details):
        if number:
            yield Text()
        yield from pieces

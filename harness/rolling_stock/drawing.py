"""Side view of a train to scale, with brakes, shared brake valves, coupled axles and sanders."""

from collections.abc import Iterator

from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyBboxPatch, Polygon, Rectangle

from railgrip.report.palette import BLACK, BLUE, GREY, ORANGE, SKY, VERMILION
from railgrip.report.style import Drawing, figure
from railgrip.rolling_stock.schema import Train

_ROW = 110.0  # m, length of train in a row of the figure
_INCHES = 0.13  # for a metre
_ROOF = 3.9  # m above the rail; train files do not have the height of a car
_FLOOR = 1.0
_BELOW = -3.4


def drawing(train: Train) -> Drawing:
    """Return the figure, leading car first, on the left; long trains take several rows."""
    rows = list(_rows(train))
    longest = max(end - start for _, start, end in rows)
    train_figure = figure(max(_INCHES * (longest + 3), 7.0), 1.15 * len(rows) + 0.7)
    axes: list[Axes] = list(train_figure.subplots(len(rows), 1, squeeze=False)[:, 0])
    for axis, (cars, start, _) in zip(axes, rows, strict=True):
        axis.set_xlim(start - 1.5, start + longest + 1.5)
        axis.set_ylim(_BELOW, _ROOF + 1.0)
        axis.set_aspect("equal")
        axis.axis("off")
        _row(axis, train, cars)
    axes[0].set_title(
        f"{train.name}: {len(train.cars)} cars, {len(train.axles)} axles, {train.length:.1f} m, "
        f"{train.mass / 1e3:.1f} t",
        loc="left",
        fontsize=10,
    )
    train_figure.supxlabel(
        "under the rail: axle and its load [t]; lines join coupled axles; brackets join those with one brake valve;\n"
        "dots: brake units of an axle; diamonds: dynamic brakes; bars on the rail: magnetic and eddy-current brakes;\n"
        "triangles: sanders; in a car: its two-stage distributor and accelerator",
        fontsize=7,
        color=GREY,
    )
    return train_figure


def _rows(train: Train) -> Iterator[tuple[range, float, float]]:
    first, begin, front = 0, 0.0, 0.0
    for number, car in enumerate(train.cars):
        if front + car.length - begin > _ROW and number > first:
            yield range(first, number), begin, front
            first, begin = number, front
        front += car.length
    yield range(first, len(train.cars)), begin, front


def _row(axes: Axes, train: Train, cars: range) -> None:
    fronts = [sum(car.length for car in train.cars[:number]) for number in range(len(train.cars) + 1)]
    axes.plot([fronts[cars.start] - 1, fronts[cars.stop] + 1], [0, 0], color=BLACK, linewidth=0.8)
    for number in cars:
        car, front = train.cars[number], fronts[number]
        body = FancyBboxPatch(
            (front + 0.5, _FLOOR), car.length - 1.0, _ROOF - _FLOOR, boxstyle="round,pad=0,rounding_size=0.5",
            facecolor="#EEF4F8", edgecolor=BLUE, linewidth=0.9,
        )  # fmt: skip
        axes.add_patch(body)
        equipment = ", ".join(filter(None, (f"{car.mass / 1e3:g} t", car.distributor, car.accelerator)))
        words = f"{car.name}\n{equipment}"
        axes.text(front + car.length / 2, 2.6, words, ha="center", va="center", fontsize=7)
        if car.coupler:
            axes.plot([front + car.length - 0.5, front + car.length + 0.5], [1.05, 1.05], color=BLACK, linewidth=2)
    for bogie in train.bogies_in_train:
        if bogie.cars[0] not in cars:
            continue
        radius, last = bogie.data.wheel_radius, bogie.position + bogie.data.wheelbase
        axes.add_patch(
            Rectangle((bogie.position - 0.5, radius), last - bogie.position + 1, 0.35, facecolor=GREY, edgecolor=GREY)
        )
        for index in bogie.axles:
            axle = train.axles[index]
            axes.add_patch(Circle((axle.position, radius), radius, facecolor="white", edgecolor=BLACK, linewidth=0.9))
            for unit in range(round(axle.units)):
                x = axle.position + 0.22 * (unit - (axle.units - 1) / 2)
                axes.add_patch(Circle((x, radius), 0.09, color=VERMILION))
            axes.text(axle.position, -0.75, f"{index + 1}", ha="center", va="center", fontsize=6)
            axes.text(axle.position, -1.45, f"{axle.mass / 1e3:.1f}", ha="center", va="center", fontsize=5, color=GREY)
            if axle.dynamic_units:
                axes.plot([axle.position], [radius + 0.2], marker="D", markersize=4, color=BLUE)
        if bogie.rail_brakes:
            middle = bogie.position + bogie.data.wheelbase / 2
            axes.add_patch(Rectangle((middle - 0.35, 0.02), 0.7, 0.22, facecolor=VERMILION, edgecolor=VERMILION))
        if bogie.data.coupled:
            axes.plot([bogie.position, last], [radius, radius], color=BLACK, linewidth=1.2)
    group = 0
    for count in train.groups_per_valve:
        members = [i for g in range(group, group + count) for i in train.groups[g]]
        group += count
        if train.axles[members[0]].car not in cars:
            continue
        left, right = train.axles[members[0]].position - 0.3, train.axles[members[-1]].position + 0.3
        axes.plot([left, left, right, right], [-2.0, -2.35, -2.35, -2.0], color=SKY, linewidth=1.2)
    for sander in train.sanders:
        axle = train.axles[sander.wheelset - 1]
        if axle.car in cars:
            x = axle.position - 0.75
            axes.add_patch(Polygon([(x - 0.25, 0.8), (x + 0.25, 0.8), (x + 0.3, 0.05)], color=ORANGE))

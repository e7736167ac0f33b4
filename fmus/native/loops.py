"""C code of CasADi functions, with loops over the equal parts of a train.

Equal wagons, bogies and axles have equal equations, and CasADi writes them out one by one: the code of a long train no
longer fits into the cache of a processor, and C compilers need a minute for it. Operations whose expressions are equal
down to the arguments of the function, and differ only in the elements of these, form a group. Each group is a loop over
its members, in which operands are elements at places that grow in equal steps or are in a table. The members of a group
are ordered as those of an operand, and groups of the same size share a loop if each member uses only the same member of
the others; what is used only in this loop is a local variable. Every operation is computed as CasADi would, so that
results are equal to the bit.
"""

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from heapq import heappop, heappush

import casadi as ca

from railgrip.fmus.native.c_source import IN_C, in_parts, number, operation_names

LONGEST = 150
"""Maximum number of operations in one loop, and in one part: the time of C compilers grows faster than the length."""

PARAMETERS = "const double **restrict arg, double **restrict res, double *restrict w"


@dataclass(slots=True, eq=False)
class _OperationGroup:
    """Operations with equal expressions.

    Attributes:
        name: Its local variable in C.
        operation: Name of the operation.
        operands: What each operand is a member of.
        first: Number of its first instruction.
        members: The members of the operands, for each member.
        users: Groups that have it as an operand.
        waits: Number of operands that are not computed yet.
        place: Place of each member in the loop.
        rows: Places of the operands, by place.
        loop: Number of its loop.
        begin: Place of its first member in `w`.
    """

    name: str
    operation: str
    operands: "tuple[_Source, ...]"
    first: int
    members: list[tuple[int, ...]] = field(default_factory=list)
    users: "list[_OperationGroup]" = field(default_factory=list)
    waits: int = 0
    place: list[int] = field(default_factory=list)
    rows: list[tuple[int, ...]] = field(default_factory=list)
    loop: int = -1
    begin: int = -1


_Source = str | int | _OperationGroup
"""A constant as text in C, an argument of the function by its place, whose members are its elements, or operations."""

_Results = Mapping[_Source, Mapping[int, list[tuple[int, int]]]]
"""Source → number of a result → its elements and the members that they are."""


def with_loops(function: ca.Function) -> str:
    """Return C code of an expanded (SX) function NAME: `static void NAME(const double **arg, double **res)`."""
    groups, results = _read(function)
    loops = _arrange(groups)
    name = function.name()
    writer = _LoopWriter(table_name=f"{name}_places", results=results)
    lines = list(writer.lines(loops))
    parts, count = [list[str]()], 0
    for size, body in lines:
        if count and count + len(body) > LONGEST:
            parts.append([])
            count = 0
        count += len(body)
        parts[-1] += body if size == 1 else [f"for (int k = 0; k < {size}; k++) {{", *body, "}"]
    return "\n".join(
        [
            *writer.table_lines(),
            *in_parts(name, PARAMETERS, parts),
            f"static void {name}(const double **arg, double **res) {{",
            f"    double w[{writer.work + 1}];",
            f"    for (int k = 0; k < {len(parts)}; k++) {name}_parts[k](arg, res, w);",
            "}",
        ]
    )


def _read(function: ca.Function) -> tuple[list[_OperationGroup], _Results]:
    groups: dict[tuple[object, ...], _OperationGroup] = {}
    values: dict[int, tuple[_Source, int]] = {}
    results: dict[_Source, dict[int, list[tuple[int, int]]]] = defaultdict(lambda: defaultdict(list))
    for k in range(function.n_instructions()):
        operation = operation_names()[function.instruction_id(k)]
        to, arguments = function.instruction_output(k), function.instruction_input(k)
        if operation == "OP_CONST":
            values[to[0]] = number(function.instruction_constant(k)), 0
        elif operation == "OP_INPUT":
            values[to[0]] = arguments[0], arguments[1]
        elif operation == "OP_OUTPUT":
            source, member = values[arguments[0]]
            results[source][to[0]].append((to[1], member))
        else:
            operands, members = zip(*(values[place] for place in arguments), strict=True)
            key = operation, *operands
            group = groups.get(key)
            if group is None:
                group = groups[key] = _OperationGroup(f"v{len(groups)}", operation, operands, k)
                for source in {operand for operand in operands if isinstance(operand, _OperationGroup)}:
                    source.users.append(group)
                    group.waits += 1
            values[to[0]] = group, len(group.members)
            group.members.append(members)
    return list(groups.values()), results


def _arrange(groups: Sequence[_OperationGroup]) -> list[list[_OperationGroup]]:
    # The groups of each loop, in an order in which operands are computed first. Of those that can follow, the loop
    # takes the one that comes first in CasADi's order, which has each value close to its uses.
    ready: dict[int, list[tuple[int, _OperationGroup]]] = defaultdict(list)

    def push(group: _OperationGroup) -> None:
        heappush(ready[len(group.members)], (group.first, group))

    for group in groups:
        if not group.waits:
            push(group)
    loops: list[list[_OperationGroup]] = []
    while any(ready.values()):
        size = min((heap[0][0], size) for size, heap in ready.items() if heap)[1]
        loop, apart = list[_OperationGroup](), list[_OperationGroup]()
        while ready[size] and len(loop) < LONGEST:
            group = heappop(ready[size])[1]
            _place_members(group)
            if any(
                isinstance(operand, _OperationGroup)
                and operand.loop == len(loops)
                and any(row[i] != place for place, row in enumerate(group.rows))
                for i, operand in enumerate(group.operands)
            ):
                apart.append(group)
                continue
            group.loop = len(loops)
            loop.append(group)
            for user in group.users:
                user.waits -= 1
                if not user.waits:
                    push(user)
        for group in apart:
            push(group)
        loops.append(loop)
    return loops


def _place_members(group: _OperationGroup) -> None:
    # Order the members as those of an operand of the same size, which makes the places in both equal.
    rows = [
        tuple(s.place[m] if isinstance(s, _OperationGroup) else m for s, m in zip(group.operands, row, strict=True))
        for row in group.members
    ]
    size = len(rows)
    keys = sorted(
        range(len(group.operands)),
        key=lambda i: not (isinstance(s := group.operands[i], _OperationGroup) and len(s.members) == size),
    )
    order = sorted(range(size), key=lambda m: [rows[m][i] for i in keys])
    group.place = [0] * size
    for place, member in enumerate(order):
        group.place[member] = place
    group.rows = [rows[member] for member in order]


@dataclass(slots=True, kw_only=True)
class _LoopWriter:
    """Writes the lines of loops.

    Attributes:
        table_name: Name of the table of places in C.
        results: What the results of the function are.
        table: Places.
        at: Where a sequence of places begins in the table.
        work: Size of the work array `w`.
        free: Places in `w` that are no longer used, by the number of members that they hold.
        ending: Groups that no loop after this one uses, by the number of the loop.
    """

    table_name: str
    results: _Results
    table: list[int] = field(default_factory=list)
    at: dict[tuple[int, ...], int] = field(default_factory=dict)
    work: int = 0
    free: dict[int, list[int]] = field(default_factory=lambda: defaultdict(list))
    ending: dict[int, list[_OperationGroup]] = field(default_factory=lambda: defaultdict(list))

    def lines(self, loops: Sequence[Sequence[_OperationGroup]]) -> Iterator[tuple[int, list[str]]]:
        """Yield the number of members and the body of each loop."""
        for source in self.results:
            if not isinstance(source, _OperationGroup):
                yield from self._copies(source)
        for number_of_loop, loop in enumerate(loops):
            yield len(loop[0].members), [line for group in loop for line in self._statements(group)]
            for group in loop:
                yield from self._copies(group)
            for group in self.ending.pop(number_of_loop, ()):
                self.free[len(group.members)].append(group.begin)

    def _statements(self, group: _OperationGroup) -> Iterator[str]:
        # The value of a group, and the results that it is.
        columns = zip(group.operands, zip(*group.rows, strict=True), strict=True)
        x, *others = (self._value(operand, places, group.loop) for operand, places in columns)
        value = _template(group.operation).format(x=x, y=others[0] if others else x)
        results = self.results.get(group, {})
        last = max((user.loop for user in group.users), default=group.loop)
        if last > group.loop or not all(self._is_whole(group, pairs) for pairs in results.values()):
            self._store(group)
            self.ending[last].append(group)
            value = f"w[{self._place(range(group.begin, group.begin + len(group.members)))}] = {value}"
        yield f"double {group.name} = {value};"
        for result, pairs in results.items():
            if self._is_whole(group, pairs):
                elements = [element for _, element in sorted((group.place[m], e) for e, m in pairs)]
                yield f"res[{result}][{self._place(elements)}] = {group.name};"

    def _store(self, group: _OperationGroup) -> None:
        free = self.free[len(group.members)]
        if free:
            group.begin = free.pop()
        else:
            group.begin = self.work
            self.work += len(group.members)

    def table_lines(self) -> list[str]:
        """Return the lines of the table of places, none if it is empty."""
        if not self.table:
            return []
        type_ = "unsigned short" if max(self.table) < 1 << 16 else "int"
        return [f"static const {type_} {self.table_name}[] = {{ {', '.join(map(str, self.table))} }};"]

    @staticmethod
    def _is_whole(group: _Source, pairs: Sequence[tuple[int, int]]) -> bool:
        # Whether each member is one element of the result, which is then written where the member is computed.
        return isinstance(group, _OperationGroup) and sorted(m for _, m in pairs) == list(range(len(group.members)))

    def _copies(self, source: _Source) -> Iterator[tuple[int, list[str]]]:
        for result, pairs in self.results.get(source, {}).items():
            if self._is_whole(source, pairs):
                continue
            places = sorted((e, source.place[m] if isinstance(source, _OperationGroup) else m) for e, m in pairs)
            to, value = self._place([e for e, _ in places]), self._value(source, [p for _, p in places])
            yield len(places), [f"res[{result}][{to}] = {value};"]

    def _value(self, source: _Source, places: Sequence[int], loop: int = -1) -> str:
        if isinstance(source, str):
            return source
        if isinstance(source, int):
            return f"arg[{source}][{self._place(places)}]"
        if source.loop == loop:
            return source.name
        return f"w[{self._place([source.begin + place for place in places])}]"

    def _place(self, places: Sequence[int]) -> str:
        # An expression of the place for each k.
        first, step = places[0], places[1] - places[0] if len(places) > 1 else 0
        if all(place == first + step * k for k, place in enumerate(places)):
            return _sum(first, step)
        key = tuple(places)
        if key not in self.at:
            self.at[key] = len(self.table)
            self.table += key
        return f"{self.table_name}[{_sum(self.at[key], 1)}]"


def _sum(first: int, step: int) -> str:
    # first + step * k, without an operation that has no effect (MISRA C:2012, rule 2.2).
    terms = [*([f"{first}"] if first or not step else []), *(["k" if step == 1 else f"{step} * k"] if step else [])]
    return " + ".join(terms)


@cache
def _template(operation: str) -> str:
    return re.sub(r"\b([xy])\b", r"{\1}", IN_C[operation])

import ast

import pytest

from tools.mutation.operator import mutants


def changes(source: str) -> list[str]:
    return [mutant.change for mutant in mutants(source)]


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("a < b", ["a < b -> a <= b", "a < b -> a >= b"]),
        ("a >= b", ["a >= b -> a > b", "a >= b -> a < b"]),
        ("a == b", ["a == b -> a != b"]),
        ("a is None", ["a is None -> a is not None"]),
        ("a not in b", ["a not in b -> a in b"]),
        ("a + b", ["a + b -> a - b"]),
        ("a / b", ["a / b -> a * b"]),
        ("a | b", ["a | b -> a & b"]),
        ("a << b", ["a << b -> a >> b"]),
        ("a and b", ["a and b -> a or b"]),
        ("not a", ["not a -> a"]),
        ("-a", ["-a -> a"]),
        ("~a", ["~a -> a"]),
        ("x = 3", ["3 -> 4"]),
        ("x = 0.5", ["0.5 -> 1.5"]),
        ("x = True", ["True -> False"]),
        ("x += y", ["Add -> Sub"]),
        ("x |= y", ["BitOr -> BitAnd"]),
        ("min(a, b)", ["min(a, b) -> max(a, b)"]),
        ("a if c else b", ["a if c else b -> b if c else a"]),
        ("if c:\n    pass", ["c -> not c"]),
        ("while c:\n    pass", ["c -> not c"]),
        ("x: int = 1", ["1 -> 2"]),
        ("def f() -> int:\n    return a", ["a -> a + 1"]),
        ("def f() -> bool:\n    return a", ["a -> not a"]),
    ],
)
def test_each_kind_of_mistake(source: str, expected: list[str]) -> None:
    assert changes(source) == expected


@pytest.mark.parametrize(
    "source",
    [
        '"""What a module says about 3 < 4."""',
        "from a import b",
        "import a as b",
        "x: Annotated[float, 3] | None",
        "@decorated(1)\ndef f(a: Literal[1]) -> Literal[2]:\n    return a",
        "x = 'a message with 2 numbers'",
        "def f() -> None:\n    return",
    ],
)
def test_what_is_no_behaviour_is_left_alone(source: str) -> None:
    assert changes(source) == []


def test_mistakes_are_found_at_every_depth_and_told_with_their_place() -> None:
    source = "def f(a: int = 5) -> float:\n    if a > 1:\n        return g(a + 2)\n    return 0.0\n"
    found = [(mutant.line, mutant.column, mutant.change) for mutant in mutants(source)]
    assert found == [
        (1, 16, "5 -> 6"),
        (2, 8, "a > 1 -> a >= 1"),
        (2, 8, "a > 1 -> a <= 1"),
        (2, 12, "1 -> 2"),
        (3, 16, "g(a + 2) -> g(a + 2) + 1"),
        (3, 18, "a + 2 -> a - 2"),
        (3, 22, "2 -> 3"),
        (4, 12, "0.0 -> 0.0 + 1"),
        (4, 12, "0.0 -> 1.0"),
    ]


def test_each_mutant_differs_in_one_place_compiles_and_leaves_no_trace() -> None:
    source = "def f(a: int) -> bool:\n    b = a * 2 - 1\n    return b < 3 and not a == 4\n"
    sound = ast.unparse(ast.parse(source))
    trees = []
    for mutant in mutants(source):
        trees.append(ast.unparse(mutant.tree))
        compile(mutant.tree, "mutant", "exec")
    assert len(set(trees)) == len(trees) > 8
    for changed in trees:
        pairs = zip(sound.splitlines(), changed.splitlines(), strict=True)
        assert sum(one != other for one, other in pairs) == 1

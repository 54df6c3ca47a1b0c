"""How a console becomes a station."""

from timonel.web.pairing import AT_ONCE, GUESSES, LIFETIME, Asked, Pairings


class Told:
    """Pairings, and what was told of them."""

    def __init__(self) -> None:
        self.began: list[Asked] = []
        self.ended: list[Asked] = []
        self.pairings = Pairings(self.began.append, self.ended.append)

    def ask(self, station: int = 2, address: str = "192.168.1.7", now: float = 0.0) -> Asked:
        asked = self.pairings.ask(station, "tablet", address, now)
        assert asked is not None
        return asked


def other(code: str) -> str:
    return f"{(int(code) + 1) % 1_000_000:06d}"


def test_who_tells_the_digits_is_the_station() -> None:
    told = Told()
    asked = told.ask(station=3)
    assert told.began == [asked]
    assert len(asked.code) == 6
    assert asked.code.isdecimal()
    assert told.pairings.tell(asked.number, asked.code, 1.0) == 3
    assert told.ended == [asked]


def test_digits_count_once() -> None:
    told = Told()
    asked = told.ask()
    told.pairings.tell(asked.number, asked.code, 1.0)
    assert told.pairings.tell(asked.number, asked.code, 1.0) is None


def test_three_wrong_ones_end_it() -> None:
    told = Told()
    asked = told.ask()
    for _ in range(GUESSES):
        assert told.pairings.tell(asked.number, other(asked.code), 1.0) is None
    assert told.ended == [asked]
    assert told.pairings.tell(asked.number, asked.code, 1.0) is None


def test_two_wrong_ones_do_not() -> None:
    told = Told()
    asked = told.ask()
    for _ in range(GUESSES - 1):
        told.pairings.tell(asked.number, other(asked.code), 1.0)
    assert told.pairings.tell(asked.number, asked.code, 1.0) == 2


def test_two_minutes_end_it() -> None:
    told = Told()
    asked = told.ask(now=10.0)
    assert told.pairings.waiting(10.0 + LIFETIME - 0.1) == [asked]
    assert told.pairings.tell(asked.number, asked.code, 10.0 + LIFETIME) is None
    assert told.ended == [asked]


def test_a_refusal_ends_it() -> None:
    told = Told()
    asked = told.ask()
    assert told.pairings.refuse(asked.number)
    assert not told.pairings.refuse(asked.number)
    assert told.pairings.tell(asked.number, asked.code, 1.0) is None


def test_the_digits_of_one_are_not_those_of_another() -> None:
    told = Told()
    first, second = told.ask(station=2), told.ask(station=3)
    while second.code == first.code:
        second = told.ask(station=3)
    assert told.pairings.tell(second.number, first.code, 1.0) is None


def test_who_asks_again_forgets_what_he_asked_before() -> None:
    told = Told()
    first = told.ask()
    second = told.ask()
    assert told.pairings.waiting(0.0) == [second]
    assert told.ended == [first]


def test_only_so_many_wait_at_once() -> None:
    told = Told()
    for number in range(AT_ONCE):
        told.ask(address=f"192.168.1.{number}")
    assert told.pairings.ask(2, "one more", "192.168.2.1", 1.0) is None
    assert told.pairings.ask(2, "one more", "192.168.2.1", LIFETIME) is not None


def test_digits_that_are_none_are_wrong() -> None:
    told = Told()
    assert told.pairings.tell(told.ask().number, "é€x!日本", 1.0) is None

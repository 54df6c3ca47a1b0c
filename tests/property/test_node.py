"""Whatever is said on the bus: a node never falls over, never floods it, and does the same again."""

from hypothesis import given
from hypothesis import strategies as st

from tests.unit.nmea2000.bus import frames_of
from timonel.core.effects import Effect
from timonel.nmea2000 import registry
from timonel.nmea2000.devices import HOMELESS, Devices
from timonel.nmea2000.identifier import split
from timonel.nmea2000.node import ANSWERS, CLAIM, MANAGED, PRODUCT, Node, NodeSettings
from timonel.nmea2000.sender import Sender

NODE = NodeSettings(unique_number=7)
OURS = NODE.name.to_bytes(8, "little")
CLAIMS_A_SECOND = 12
PRODUCT_FRAMES = 20

# Bytes at random, and those that are likely to reach something: NAMEs around ours, functions of 126208 on our PGNs.
NAMES = st.integers(-3, 3).map(lambda by: (NODE.name + by).to_bytes(8, "little"))
TARGETS = st.sampled_from([60928, 126464, 126993, 126996, 126998, 127237, 65284, 61184])
FUNCTIONS = st.tuples(st.integers(0, 7), TARGETS, st.binary(max_size=40)).map(
    lambda parts: bytes((parts[0],)) + parts[1].to_bytes(3, "little") + parts[2]
)
PAYLOADS = st.one_of(st.binary(max_size=60), NAMES, FUNCTIONS, NAMES.map(lambda name: name + b"\x28"))
HEARD = st.tuples(
    st.sampled_from(sorted(MANAGED | {127237})),
    PAYLOADS,
    st.integers(0, 255),
    st.sampled_from([35, 36, 255, 7]),
    st.floats(0, 0.3),
)


def played(heard: list[tuple[int, bytes, int, int, float]]) -> tuple[Node, list[tuple[float, Effect]]]:
    devices = Devices()
    node = Node(NODE, Sender(35), devices, 0.0)
    now, effects = 0.0, []
    for pgn, payload, source, destination, pause in heard:
        now += pause
        while (due := node.deadline) <= now:
            effects += [(due, effect) for effect in node.expire(due)]
        message = registry.decode(pgn, payload)
        effects += [(now, effect) for effect in node.receive(pgn, message, payload, source, destination, now)]
        assert len(devices) <= 254 + HOMELESS
    return node, effects


@given(st.lists(HEARD, max_size=80))
def test_a_node_does_what_it_does_and_does_it_again(heard: list[tuple[int, bytes, int, int, float]]) -> None:
    node, effects = played(heard)
    assert effects == played(heard)[1]
    assert node.address < 252 or not node.operating
    said = [(now, split(frame.identifier).pgn) for now, effect in effects for frame in frames_of([effect])]
    for now, _ in said:
        within = [pgn for at, pgn in said if now <= at < now + 1]
        assert within.count(CLAIM) <= CLAIMS_A_SECOND
        assert within.count(PRODUCT) <= (ANSWERS + 1) * PRODUCT_FRAMES

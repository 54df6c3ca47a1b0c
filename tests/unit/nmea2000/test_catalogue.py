import msgspec
import numpy as np
import pytest

from tests.catalogue import plain, table
from timonel.nmea2000 import catalogue
from timonel.nmea2000.catalogue_codec import source
from timonel.nmea2000.catalogue_columns import columns, listed, select, words

HEADING = bytes.fromhex("FF725AFF7FFF7FFD")
POSITION = bytes.fromhex(  # 129029 with two reference stations
    "FFA54EB2896E1E00DFF69EE85F6108A0E5A2762D701903C05BF1470000000010FC09FE7FFE7F0E0600000281079600620EB400"
)


def decoded(pgn, text, labels=True):
    payload = bytes.fromhex(text)
    found = catalogue.find(pgn, payload)
    assert found is not None
    return found.as_dict(payload, labels)


def test_a_heading_is_read_as_canboat_names_it():
    found = catalogue.find(127250, HEADING)
    assert found is catalogue.by_id("vesselHeading")
    assert found.as_json(HEADING) == b'{"heading":2.3154,"reference":"Magnetic"}'
    assert found.as_json(HEADING, labels=False) == b'{"heading":2.3154,"reference":1}'


def test_a_message_is_an_object_with_none_for_what_is_not_available():
    message = catalogue.by_id("vesselHeading").decode(HEADING)
    assert (message.heading, message.reference, message.sid, message.deviation) == (2.3154, "Magnetic", None, None)
    with pytest.raises(AttributeError):
        message.heading = 0.0


def test_a_definition_tells_its_title_source_and_fields():
    found = catalogue.by_id("vesselHeading")
    assert (found.title, found.source, found.fast) == ("Vessel Heading", "canboat 9.0.0 `vesselHeading`", False)
    assert [(field.id, field.unit, field.resolution) for field in found.fields][1] == ("heading", "rad", 0.0001)
    assert found.fields[4].labels == {0: "True", 1: "Magnetic", 2: "Error"}


def test_an_unknown_definition_is_a_key_error():
    with pytest.raises(KeyError):
        catalogue.by_id("noSuchMessage")


def test_a_pgn_that_canboat_does_not_know_is_none():
    assert catalogue.find(130762, bytes(8)) is None
    assert catalogue.variants(130762) == ()


def test_variants_are_told_apart_by_their_constants():
    assert catalogue.find(126720, bytes.fromhex("A3990F00FFFFFFFFFFFFFFFF")).id == "fusionSetSetting"
    assert catalogue.find(65280, bytes.fromhex("1399040500000200")).id == "navicoDeviceStatus"


def test_what_nobody_explained_has_its_maker_and_its_bytes():
    assert decoded(65370, "13991122334455") == {
        "manufacturerCode": "Navico",
        "industryCode": "Marine Industry",
        "data": "1122334455",
    }


def test_a_message_too_short_for_its_constants_is_not_taken_for_a_variant():
    assert catalogue.find(65280, b"\x13").fallback


def test_error_and_reserved_values_are_none():
    for special in ("FD", "FE", "FF"):
        assert decoded(127250, f"{special}FFFFFF7FFF7F00") == {"reference": "True"}


def test_a_field_that_the_message_ends_in_is_none():
    assert decoded(127250, "05725A") == {"sid": 5, "heading": 2.3154}
    assert decoded(127250, "0572") == {"sid": 5}
    assert decoded(127250, "") == {}


def test_a_message_longer_than_its_definition_is_read_as_far_as_that_goes():
    assert decoded(59904, "0DF201FFFFFFFFFF") == {"pgn": 127501}


def test_a_number_without_a_label_stays_a_number():
    assert decoded(130306, "FF0000000006") == {"windSpeed": 0.0, "windAngle": 0.0, "reference": 6}


def test_repeating_sets_are_lists():
    found = catalogue.find(129029, POSITION).as_dict(POSITION)
    assert found["list"] == [
        {"referenceStationType": "GLONASS", "referenceStationId": 120, "ageOfDgnssCorrections": 1.5},
        {"referenceStationType": "GPS+GLONASS", "referenceStationId": 230, "ageOfDgnssCorrections": 1.8},
    ]


def test_items_cut_short_keep_what_is_whole():
    found = catalogue.find(129029, POSITION).as_dict(POSITION[:-1])
    assert found["list"][1] == {"referenceStationType": "GPS+GLONASS", "referenceStationId": 230}


def test_a_count_that_is_not_available_is_no_items():
    found = catalogue.find(129029, POSITION).as_dict(POSITION[:42] + b"\xff" + POSITION[43:])
    assert "list" not in found


def test_parameters_are_the_fields_of_the_commanded_message():
    assert decoded(126208, "0112F101F802010502FFFF")["list"] == [
        {"parameter": 1, "value": 5},
        {"parameter": 2},
    ]
    assert decoded(126208, "0112F101F8020201020501")["list"][0] == {"parameter": 2, "value": 0.0513}


def test_parameters_of_a_message_that_could_be_several_are_bytes():
    assert decoded(126208, "0112FE01F80109AABB")["list"] == [{"parameter": 9, "value": "AABB"}]


def test_an_acknowledgement_has_two_results_in_a_byte():
    assert decoded(126208, "0212F101FF0321F0")["list"] == [
        {"parameter": "Invalid parameter field"},
        {"parameter": "Temporary error"},
        {"parameter": "Acknowledge"},
    ]


def test_a_key_tells_what_its_value_is():
    assert decoded(130824, "7D990B203512FD20FFFF")["list"] == [
        {"key": "Rudder Angle", "length": 2, "value": 0.4661},
        {"key": 253, "length": 2, "value": "FFFF"},
    ]


def test_bits_are_the_labels_of_those_that_are_set():
    payload = bytes(20) + bytes.fromhex("0180000000000000")
    found = catalogue.find(127489, payload)
    assert found.as_dict(payload)["discreteStatus1"] == ["Check Engine", "Emergency Stop"]
    assert found.as_dict(payload, labels=False)["discreteStatus1"] == 0x8001


def test_a_label_may_depend_on_another_field():
    assert decoded(60928, "F9FFBFFF009696C0")["deviceFunction"] == "Fluid Level"


@pytest.mark.parametrize(
    ("text", "expected"),
    [("4142FF", "AB"), ("41424000", "AB"), ("C3A9", "é"), ("E9", "é"), ("FFFF", None), ("2020", None)],
)
def test_text_of_fixed_size_ends_at_its_padding(text, expected):
    payload = bytes.fromhex("34089A02") + bytes.fromhex(text).ljust(32, b"\xff")
    assert catalogue.find(126996, payload).as_dict(payload).get("modelId") == expected


def test_fields_that_python_cannot_name_keep_their_ids_in_dictionaries():
    found = catalogue.by_id("furunoSensorSetup")
    assert "_3AxisOffset" in found.message.__struct_fields__
    assert "3AxisOffset" in found.message.__struct_encode_fields__


def test_the_decoder_is_python_that_can_be_read():
    assert source(catalogue.by_id("vesselHeading")).startswith("def decode(data):\n try:\n  (w0_0, w1_0, ")


def test_a_number_counted_from_an_offset_is_as_short_as_it_is_sent():
    found = catalogue.by_id("batteryConfigurationStatus")
    bits = sum(field.bits for field in found.fields[: [field.id for field in found.fields].index("peukertExponent")])
    for raw in range(253):
        payload = (raw << bits).to_bytes(8, "little")
        assert found.decode(payload).peukertExponent == round(1 + raw * 0.002, 3)


# Columns --------------------------------------------------------------------------------------------


def test_columns_are_floats_with_nan_and_integers_with_a_mask():
    payloads = [HEADING, bytes.fromhex("050000FF7FFF7FFF")]
    found = columns(catalogue.by_id("vesselHeading"), *table(payloads)).fields
    assert found["heading"].values.tolist() == [2.3154, 0.0]
    assert np.isnan(found["deviation"].values).all()
    assert found["sid"].values.dtype == np.uint8
    assert found["sid"].valid.tolist() == [False, True]
    assert listed(found["reference"]) == [1, None]
    assert words(found, "reference") == ["Magnetic", None]


def test_a_column_without_gaps_has_no_mask():
    found = columns(catalogue.by_id("isoRequest"), *table([bytes.fromhex("0DF201")] * 3)).fields
    assert found["pgn"].valid is None
    assert found["pgn"].values.tolist() == [127501] * 3


def test_items_know_their_row():
    payloads = [POSITION, POSITION[:42] + b"\x00", POSITION]
    (items,) = columns(catalogue.by_id("gnssPositionData"), *table(payloads)).groups
    assert items.rows.tolist() == [0, 0, 2, 2]
    assert listed(items.fields["referenceStationId"]) == [120, 230, 120, 230]


def test_bytes_are_columns_of_bytes():
    found = columns(catalogue.by_id("navicoDeviceStatus"), *table([bytes.fromhex("1399040500000200")] * 2)).fields
    assert found["data"].values.shape == (2, 5)
    assert listed(found["data"]) == [bytes.fromhex("0500000200")] * 2


def test_rows_are_sorted_by_variant():
    payloads = [bytes.fromhex(text) for text in ("1399040500000200", "1398112233445566", "1399040500000201")]
    found = [(definition.id, rows.tolist()) for definition, rows in select(65280, *table(payloads))]
    assert found[0] == ("navicoDeviceStatus", [0, 2])
    assert found[1][0].startswith("0xff00")
    assert select(130762, *table(payloads))[0][0] is None


def test_no_rows_are_columns_without_rows():
    for identifier in ("vesselHeading", "gnssPositionData", "navigationRouteWpInformation", "bGKeyValueData"):
        definition = catalogue.by_id(identifier)
        found = columns(definition, np.zeros((0, 0), np.uint8), np.zeros(0, np.intp))
        assert all(len(column.values) == 0 for column in found.fields.values())
        assert all(len(items.rows) == 0 for items in found.groups)


def test_a_decoded_message_is_a_frozen_struct_of_plain_values():
    message = catalogue.find(129029, POSITION).decode(POSITION)
    assert msgspec.json.decode(msgspec.json.encode(message)) == plain(message)

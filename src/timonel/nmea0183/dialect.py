"""The dialects that OUT ports speak (spec/boat.md, Sentences sent)."""

from timonel.nmea0183.checksum import seal
from timonel.nmea0183.sentence import Sentence
from timonel.nmea0183.sentences import DPT, GLL, VHW


def encode_ar10(sentence: Sentence, talker: str = "II") -> bytes:
    """`sentence` as edition 1.0 of the concentrator's document prints it.

    Three differ from NMEA 0183: VHW lacks two fields, DPT's offset is a literal 0.0, GLL has whole seconds
    and no mode. All others are those of the standard. Raises EncodeError as `Sentence.encode` does.
    """
    standard = sentence.encode(talker)
    fields = standard[1:-5].decode("ascii").split(",")
    match sentence:
        case VHW():
            return seal(",".join([fields[0], "", "", *fields[5:]]))
        case DPT():
            return seal(",".join([*fields[:2], "0.0"]))
        case GLL():
            return seal(",".join([*fields[:5], fields[5][:6], fields[6]]))
    return standard

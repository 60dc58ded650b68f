"""Signatures of JSON objects: Ed25519 (RFC 8032) over the canonical JSON of all values but the signature.

Keys are PEM files as `openssl genpkey -algorithm ed25519` and `openssl pkey -pubout` write them. A signed object has
`signature`: `key`, the public key, and `value`, both in base64.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from uwsim.base.extras import need_extra

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

SIGNATURE = "signature"


def signed(values: Mapping[str, Any], key: Path) -> dict[str, Any]:
    """Return values with the signature of a private key, which must have no pass phrase.

    Raises OSError, MissingExtraError, or ValueError for a file that is no such key.
    """
    _need()
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
    from cryptography.hazmat.primitives.serialization import load_pem_private_key

    try:
        private = load_pem_private_key(key.read_bytes(), None)
    except (ValueError, TypeError):
        private = None
    if not isinstance(private, Ed25519PrivateKey):
        raise ValueError(f"'{key}': must be an Ed25519 private key as PEM, without a pass phrase")
    value = base64.b64encode(private.sign(_canonical(values))).decode()
    return {**values, SIGNATURE: {"key": _text(private.public_key()), "value": value}}


def signer_of(values: Mapping[str, Any], what: str, key: Path | None = None) -> str:
    """Return the public key, in base64, by which values are signed.

    what: the values' file, for messages. key: the public key that must have signed them. Raises OSError,
    MissingExtraError, or ValueError for values that are not signed, not as they were signed, or signed by another key.
    """
    if SIGNATURE not in values:
        raise ValueError(f"{what}: has no signature")
    _need()
    from cryptography.exceptions import InvalidSignature
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

    try:
        signature = values[SIGNATURE]
        found = Ed25519PublicKey.from_public_bytes(base64.b64decode(signature["key"], validate=True))
        found.verify(base64.b64decode(signature["value"], validate=True), _canonical(values))
    except (InvalidSignature, KeyError, TypeError, ValueError):
        raise ValueError(f"{what}: its signature is not that of its content") from None
    if key is not None and _text(found) != _text(_public_key(key)):
        raise ValueError(f"{what}: is signed by another key than that of '{key}': {_text(found)}")
    return _text(found)


def _need() -> None:
    need_extra("cryptography", "a signature")


def _canonical(values: Mapping[str, Any]) -> bytes:
    unsigned = {name: value for name, value in values.items() if name != SIGNATURE}
    return json.dumps(unsigned, sort_keys=True, separators=(",", ":")).encode()


def _text(key: Ed25519PublicKey) -> str:
    return base64.b64encode(key.public_bytes_raw()).decode()


def _public_key(path: Path) -> Ed25519PublicKey:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey
    from cryptography.hazmat.primitives.serialization import load_pem_public_key

    try:
        found = load_pem_public_key(path.read_bytes())
    except ValueError:
        found = None
    if not isinstance(found, Ed25519PublicKey):
        raise ValueError(f"'{path}': must be an Ed25519 public key as PEM")
    return found

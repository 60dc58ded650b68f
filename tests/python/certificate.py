"""A certificate for localhost, and a client that uses it, for tests of encryption."""

import asyncio
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from websockets.asyncio.client import connect

PATIENCE_S = 10.0


def write_certificate(folder: Path) -> tuple[Path, Path]:
    """Write a certificate and its private key; return their paths."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "localhost")])
    now = datetime.now(UTC)
    certificate = (
        x509.CertificateBuilder(name, name, key.public_key(), x509.random_serial_number())
        .not_valid_before(now - timedelta(days=1))
        .not_valid_after(now + timedelta(days=1))
        .add_extension(x509.SubjectAlternativeName([x509.DNSName("localhost")]), critical=False)
        .sign(key, hashes.SHA256())
    )
    private = (serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
    certfile, keyfile = folder / "cert.pem", folder / "key.pem"
    keyfile.write_bytes(key.private_bytes(*private))
    certfile.write_bytes(certificate.public_bytes(serialization.Encoding.PEM))
    return certfile, keyfile


def first_frame(url: str, *requests: str, **options: Any) -> Any:
    """Connect, send the requests and return the first frame received, on one thread as the client's."""

    async def converse() -> Any:
        async with connect(url, **options) as client:
            for request in requests:
                await client.send(request)
            return await asyncio.wait_for(client.recv(), PATIENCE_S)

    return asyncio.run(converse())

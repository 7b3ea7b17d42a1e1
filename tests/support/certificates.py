"""Files for TLS: an authority, and a certificate and key that it signed."""

import subprocess
from pathlib import Path


def certificates(folder: Path) -> dict[str, str]:
    """Make them in a folder that is made, too; return the files by the names of `--tls-`."""
    folder.mkdir()
    words = ["openssl", "req", "-x509", "-nodes", "-days", "2", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"]
    signed = ["-CA", "ca.pem", "-CAkey", "ca-key.pem"]
    for more in (
        ["-subj", "/CN=authority", "-keyout", "ca-key.pem", "-out", "ca.pem"],
        ["-subj", "/CN=tumble", "-keyout", "key.pem", "-out", "cert.pem", *signed],
    ):
        subprocess.run([*words, *more], cwd=folder, check=True, capture_output=True)
    return {name: str(folder / f"{name}.pem") for name in ("ca", "cert", "key")}

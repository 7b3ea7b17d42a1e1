"""Which address of a scheduler may be used: Dask's protocol runs code that it is sent."""

import ssl
from collections.abc import Mapping
from ipaddress import ip_address
from pathlib import Path
from urllib.parse import urlsplit

from tumble.compare.run.cluster.on_worker import BadCluster

TLS = ("ca", "cert", "key")
TLS_OPTIONS = "--tls-ca, --tls-cert and --tls-key"


def check_address(address: str | None, tls: Mapping[str, str], is_insecure: bool) -> None:
    """Refuse what cannot be an address, and one of another machine without encryption.

    Parameters
    ----------
    address : HOST:PORT, tcp://HOST:PORT or tls://HOST:PORT; None: no scheduler, and so no certificates
    tls : files of authority, certificate and key, by the names in TLS
    is_insecure : whether an address of another machine may do without those

    Raises
    ------
    BadCluster : it cannot be used
    """
    if address is None:
        if tls:
            raise BadCluster(f"{TLS_OPTIONS} are for --scheduler tls://HOST:PORT")
        return
    parts = urlsplit(address if "://" in address else f"tcp://{address}")
    try:
        host, port = parts.hostname or "", parts.port
    except ValueError:
        host, port = "", None
    if parts.scheme not in ("tcp", "tls") or not host or not port:
        raise BadCluster(f"--scheduler {address}: must be HOST:PORT, tcp://HOST:PORT or tls://HOST:PORT")
    if parts.scheme == "tls":
        if {*tls} != {*TLS}:
            raise BadCluster(f"--scheduler {address}: give {TLS_OPTIONS}")
        check_certificates(tls)
    elif tls:
        raise BadCluster(f"--scheduler {address}: {TLS_OPTIONS} are for tls://HOST:PORT")
    elif not is_insecure and not is_loopback(host):
        raise BadCluster(
            f"--scheduler {address}: whoever reaches this port can run code here and there: use tls://HOST:PORT with "
            f"{TLS_OPTIONS}, or --insecure-scheduler in a network that you trust"
        )


def check_certificates(tls: Mapping[str, str]) -> None:
    """Refuse files that are no authority, or no certificate with its key.  Raises BadCluster."""
    for name in TLS:
        if not Path(tls[name]).is_file():
            raise BadCluster(f"--tls-{name} {tls[name]}: no such file")
    context = ssl.create_default_context()
    try:
        context.load_verify_locations(tls["ca"])
    except ssl.SSLError:
        raise BadCluster(f"--tls-ca {tls['ca']}: no certificate in PEM format") from None
    try:
        context.load_cert_chain(tls["cert"], tls["key"])
    except ssl.SSLError:
        files = f"--tls-cert {tls['cert']} and --tls-key {tls['key']}"
        raise BadCluster(f"{files}: no certificate and its private key in PEM format") from None


def is_loopback(host: str) -> bool:
    """Whether a name or address is this machine's own."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"

"""Which addresses of a scheduler are refused, each in one line, before anything connects."""

import pytest
from certificates import certificates

from tumble.compare.run.cluster.address import TLS, check_address
from tumble.compare.run.cluster.on_worker import BadCluster


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> dict[str, str]:
    return certificates(tmp_path_factory.mktemp("tls") / "files")


def test_addresses_that_may_be_used(files):
    for own in ("127.0.0.1:8786", "tcp://localhost:1", "[::1]:8786"):
        check_address(own, {}, False)
    check_address("tcp://10.0.0.1:8786", {}, True)
    check_address("tls://node:8786", files, False)
    check_address(None, {}, False)


@pytest.mark.parametrize(
    ("address", "given", "said"),
    [
        ("10.0.0.1:8786", (), "whoever reaches this port can run code here and there: use tls://HOST:PORT with"),
        ("tcp://node:8786", (), "or --insecure-scheduler in a network that you trust"),
        ("tcp://node:8786", TLS, "are for tls://HOST:PORT"),
        ("127.0.0.1:8786", ("ca",), "are for tls://HOST:PORT"),
        (None, ("key",), "--tls-ca, --tls-cert and --tls-key are for --scheduler tls://HOST:PORT"),
        ("tls://node:8786", ("ca",), "give --tls-ca, --tls-cert and --tls-key"),
        ("http://127.0.0.1:8786", (), "must be HOST:PORT"),
        ("127.0.0.1", (), "must be HOST:PORT"),
        ("127.0.0.1:x", (), "must be HOST:PORT"),
    ],
)
def test_an_address_that_others_could_reach_needs_encryption(address, given, said, files):
    with pytest.raises(BadCluster) as refused:
        check_address(address, {name: files[name] for name in given}, False)
    assert said in str(refused.value)


def test_files_that_are_no_certificates_are_named(files, tmp_path):
    nowhere, empty = str(tmp_path / "nowhere.pem"), tmp_path / "empty.pem"
    empty.write_text("")
    for altered, said in (
        ({"ca": nowhere}, f"--tls-ca {nowhere}: no such file"),
        ({"ca": str(empty)}, f"--tls-ca {empty}: no certificate in PEM format"),
        ({"cert": files["key"], "key": files["cert"]}, f"--tls-cert {files['key']} and --tls-key {files['cert']}: no"),
        ({"cert": files["ca"]}, "no certificate and its private key"),
    ):
        with pytest.raises(BadCluster) as refused:
            check_address("tls://node:8786", {**files, **altered}, False)
        assert said in str(refused.value)

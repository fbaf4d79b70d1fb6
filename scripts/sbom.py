#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""sbom.py VERSION PACKAGE.deb...: contents and dependencies of the packages, as SPDX 2.3 (JSON). Versions of what they
need are those that are installed here, with which they were built. SOURCE_DATE_EPOCH is its date."""
import datetime
import hashlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path


def output(*words: str) -> str:
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout.strip()


def identifier(name: str) -> str:
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", name)


def dependencies(deb: str) -> set:
    """Names without versions; of alternatives the first."""
    words = output("dpkg-deb", "-f", deb, "Depends").split(",")
    return {word.split("|")[0].split("(")[0].strip() for word in words if word.strip()}


def package(name: str, version: str, file: str = "") -> dict:
    made = {"SPDXID": identifier(name), "name": name, "versionInfo": version, "downloadLocation": "NOASSERTION",
            "filesAnalyzed": False, "licenseConcluded": "NOASSERTION",
            "licenseDeclared": "Apache-2.0" if file else "NOASSERTION", "copyrightText": "NOASSERTION"}
    if file:
        digest = hashlib.sha256(Path(file).read_bytes()).hexdigest()
        made |= {"packageFileName": Path(file).name, "checksums": [{"algorithm": "SHA256", "checksumValue": digest}]}
    return made


def main() -> None:
    version, debs = sys.argv[1], sys.argv[2:]
    own = {output("dpkg-deb", "-f", deb, "Package"): deb for deb in debs}
    packages = [package(name, version, deb) for name, deb in own.items()]
    needed = {name: sorted(dependencies(deb)) for name, deb in own.items()}
    for name in sorted(set().union(*needed.values()) - own.keys()):
        packages.append(package(name, output("dpkg-query", "-W", "-f=${Version}", name)))
    relations = [{"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES",
                  "relatedSpdxElement": identifier(name)} for name in own]
    relations += [{"spdxElementId": identifier(name), "relationshipType": "DEPENDS_ON",
                   "relatedSpdxElement": identifier(other)} for name in own for other in needed[name]]
    date = datetime.datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), datetime.timezone.utc)
    document = {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
                "name": f"stereogrid-{version}", "documentNamespace": f"urn:stereogrid:{version}:{date:%Y%m%dT%H%M%SZ}",
                "creationInfo": {"created": f"{date:%Y-%m-%dT%H:%M:%SZ}", "creators": ["Tool: stereogrid/scripts/sbom.py"]},
                "packages": packages, "relationships": relations}
    json.dump(document, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()

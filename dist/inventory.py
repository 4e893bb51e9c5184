"""Writes what the programs are made of: the bill of materials in the form of CycloneDX 1.5, and the
licences of others. Both follow from Cargo.lock and the sources that cargo has fetched.

    dist/inventory.py FOLDER        latchgate.cdx.json and THIRD-PARTY.txt
"""

import datetime
import json
import os
import pathlib
import re
import subprocess
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
TARGET = "x86_64-unknown-linux-gnu"
PROGRAMS = ["latchgate", "latchgate-service"]
LICENCE_FILE = re.compile(r"^(licen[cs]e|copying|copyright|notice|unlicense)", re.IGNORECASE)
# Texts that ask nothing of whoever hands the program on but to be handed on with it.
PERMISSIVE = {"MIT", "Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "ISC", "Zlib", "0BSD", "CC0-1.0", "BSL-1.0",
              "Unicode-3.0", "Unlicense", "MIT-0"}


def main():
    folder = pathlib.Path(sys.argv[1])
    metadata = json.loads(output("cargo", "metadata", "--format-version=1", "--locked", f"--filter-platform={TARGET}"))
    packages = {package["id"]: package for package in metadata["packages"]}
    needed = needed_by_programs(metadata, packages)
    check_licences([packages[name] for name in needed])
    bill = bill_of_materials(needed, packages)
    (folder / "latchgate.cdx.json").write_text(json.dumps(bill, indent=1, sort_keys=True) + "\n")
    (folder / "THIRD-PARTY.txt").write_text(third_party([packages[name] for name in needed]))


def output(*command):
    return subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def needed_by_programs(metadata, packages):
    """Returns the packages that the programs are linked from, each with those it needs."""
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    needed = {}
    waiting = [name for name, package in packages.items() if package["name"] in PROGRAMS]
    while waiting:
        name = waiting.pop()
        if name not in needed:
            linked = [dep["pkg"] for dep in nodes[name]["deps"] if any(kind["kind"] is None for kind in dep["dep_kinds"])]
            needed[name] = sorted(linked)
            waiting.extend(linked)
    return dict(sorted(needed.items(), key=lambda item: (packages[item[0]]["name"], packages[item[0]]["version"])))


def check_licences(packages):
    """Ends where a licence asks for more than to be handed on."""
    for package in packages:
        expression = (package["license"] or "none").replace("/", " OR ").replace(" WITH LLVM-exception", "")
        # Of alternatives one is enough; what is joined by AND counts whole.
        alternatives = re.split(r"\bOR\b", re.sub(r"[()]", " ", expression))
        allowed = [{word for word in part.split() if word != "AND"} <= PERMISSIVE for part in alternatives]
        joined = all(allowed) if "AND" in expression else any(allowed)
        if not joined:
            sys.exit(f"dist/inventory.py: {package['name']} {package['version']} has the licence {expression}; "
                     "read it, then add it to PERMISSIVE, or leave the package out")


def bill_of_materials(needed, packages):
    checksums = {(package["name"], package["version"]): package.get("checksum")
                 for package in tomllib.loads((ROOT / "Cargo.lock").read_text())["package"]}

    def reference(name):
        return f"pkg:cargo/{packages[name]['name']}@{packages[name]['version']}"

    def component(name):
        package = packages[name]
        entry = {"type": "library", "bom-ref": reference(name), "name": package["name"], "version": package["version"],
                 "purl": reference(name), "licenses": [{"expression": package["license"].replace("/", " OR ")}]}
        checksum = checksums[package["name"], package["version"]]
        if checksum:
            entry["hashes"] = [{"alg": "SHA-256", "content": checksum}]
        return entry

    rust = output("rustc", "-V").split()[1]
    glibc = output("getconf", "GNU_LIBC_VERSION").split()[1]
    linked = [
        {"type": "library", "bom-ref": "rust-std", "name": "rust-std", "version": rust,
         "licenses": [{"expression": "MIT OR Apache-2.0"}]},
        {"type": "library", "bom-ref": "glibc", "name": "glibc", "version": glibc,
         "licenses": [{"expression": "LGPL-2.1-or-later"}]},
    ]
    root = next(name for name in needed if packages[name]["name"] == "latchgate")
    instant = datetime.datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), datetime.timezone.utc)
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"timestamp": instant.strftime("%Y-%m-%dT%H:%M:%SZ"), "component": {**component(root), "type": "application"}},
        "components": [component(name) for name in needed if name != root] + linked,
        "dependencies": [{"ref": reference(name), "dependsOn": [reference(dep) for dep in deps]} for name, deps in needed.items()],
    }


def third_party(packages):
    """Returns the licences of all packages of others, each text once with those that it is of."""
    of_text = {}
    for package in packages:
        if package["source"] is None:
            continue
        folder = pathlib.Path(package["manifest_path"]).parent
        files = sorted(path for path in folder.iterdir() if path.is_file() and LICENCE_FILE.match(path.name))
        title = f"{package['name']} {package['version']} ({package['license']}; {', '.join(package['authors']) or 'its authors'})"
        for text in [path.read_text(errors="replace").strip() for path in files] or [""]:
            of_text.setdefault(" ".join(text.split()), (text, []))[1].append(title)
    _, bare = of_text.pop("", ("", []))
    parts = [HEAD]
    if bare:
        parts.append("The following bring no text; that of their licence is LICENSE-MIT or LICENSE-APACHE beside this file, "
                     "or among those below:\n\n" + "\n".join(bare))
    parts += ["\n".join(titles) + "\n\n" + text for text, titles in of_text.values()]
    # Debian's own account of the C library, and the licence that it points to.
    parts.append("GNU C Library\n\n" + pathlib.Path("/usr/share/doc/libc6/copyright").read_text().strip())
    parts.append(pathlib.Path("/usr/share/common-licenses/LGPL-2.1").read_text().strip())
    return ("\n\n" + "=" * 100 + "\n\n").join(parts) + "\n"


HEAD = """\
latchgate is MIT or Apache-2.0. The programs hold parts of others, named here with their licences.

Rust's standard library: MIT or Apache-2.0, the Rust project's developers. SQLite (in latchgate-serve): public domain.
The GNU C Library is linked statically. It is LGPL-2.1 or later, its text comes last. Whoever wants another version
of it in the programs builds them anew from the project's source, by dist/build."""

main()

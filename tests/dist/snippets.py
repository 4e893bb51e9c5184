"""Runs the commands of each snippet in docs/gate.md and of dist/ci on the archive, as the CI systems would: once on
a gate that stands, once on one that does not.

    tests/dist/snippets.py ARCHIVE
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import yaml

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
GATE = """require = "{required}"

[[recordings]]
files = "*.csv"

[[designs]]
name = "paper"
"""
# What others keep; with a path that there must be once the job is over.
KNOWN = {"actions/checkout@v4": None, "actions/cache/restore@v4": None, "actions/cache/save@v4": "path",
         "actions/upload-artifact@v4": "path"}


def main():
    archive = pathlib.Path(sys.argv[1]).resolve()
    section = (ROOT / "docs/gate.md").read_text().split("## In a pipeline")[1].split("\n## ")[0]
    blocks = re.findall(r"```(\w+)\n(.*?)```", section, re.DOTALL)
    assert [kind for kind, _ in blocks] == ["yaml", "yaml", "groovy"], blocks
    jobs = {"GitHub": lambda place: github(yaml.safe_load(blocks[0][1]), place),
            "GitHub without a cache": lambda place: github(yaml.safe_load(blocks[0][1]), place, cache="false"),
            "GitLab": lambda place: gitlab(yaml.safe_load(blocks[1][1]), place),
            "Jenkins": lambda place: jenkins(blocks[2][1], place)}
    for name, job in jobs.items():
        for required, code in [("fail", 0), ("pass", 1)]:
            with tempfile.TemporaryDirectory() as folder:
                place = workplace(pathlib.Path(folder), archive, required)
                found = job(place)
                assert found == code, f"{name}: a gate that requires {required} ended with {found}, expected {code}"
                print(f"{name}: a gate that requires {required} ends with {code}")


def workplace(place, archive, required):
    """Makes a repository with a recording that opens the lever, the archive, and a file of each CI system."""
    for source, target in [(archive, f"tools/{archive.name}"), (ROOT / "signals/burst.csv", "crash/burst.csv"),
                           (ROOT / "signals/burst.csv.toml", "crash/burst.csv.toml"),
                           (ROOT / "dist/ci/action.yml", ".github/actions/latchgate/action.yml"),
                           (ROOT / "dist/ci/gitlab.yml", "ci/latchgate.yml")]:
        (place / target).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, place / target)
    (place / "crash/gate.toml").write_text(GATE.format(required=required))
    return place


def shell(place, script, environment):
    done = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", script], cwd=place, text=True, stdout=subprocess.PIPE,
                          env={"PATH": "/usr/bin:/bin", **environment})
    return done.returncode, done.stdout


def github(workflow, place, **others):
    temp = place / "runner-temp"
    temp.mkdir()
    summary, added = place / "step-summary", temp / "path"
    summary.touch()
    added.touch()
    said, failed = "", 0
    for step in workflow["jobs"]["latch"]["steps"]:
        if not step["uses"].startswith("./"):
            assert step["uses"] in KNOWN, step
            continue
        action = yaml.safe_load((place / step["uses"] / "action.yml").read_text())
        inputs = {name: given.get("default") for name, given in action["inputs"].items()} | step["with"] | others
        assert None not in inputs.values() and inputs.keys() == action["inputs"].keys(), inputs

        def value(text):
            words = {f"inputs.{name}": given for name, given in inputs.items()}
            words |= {"runner.temp": str(temp), "github.run_id": "1", "github.run_attempt": "1"}
            return re.sub(r"\$\{\{ (.*?) \}\}", lambda found: words[found[1]], text)

        for part in action["runs"]["steps"]:
            condition = part.get("if", "")
            if failed and "always()" not in condition or inputs["cache"] == "false" and "inputs.cache" in condition:
                continue
            if "uses" in part:
                expected = KNOWN[part["uses"]]
                # Two gates of one workflow do not write over each other's.
                kept = part["with"].get("key") or part["with"]["name"]
                assert "${{ inputs.name }}" in kept, f"{part['name']}: {kept} does not bear the input `name`"
                there = expected is None or pathlib.Path(place, value(part["with"][expected])).exists()
                assert there, f"{part['name']}: {part['with']} is not there"
                continue
            environment = {name: value(text) for name, text in part.get("env", {}).items()}
            environment["PATH"] = ":".join(added.read_text().split() + ["/usr/bin", "/bin"])
            environment |= {"RUNNER_TEMP": str(temp), "GITHUB_PATH": str(added), "GITHUB_STEP_SUMMARY": str(summary)}
            code, out = shell(place, part["run"], environment)
            said, failed = said + out, failed or code
    assert "burst.csv" in summary.read_text(), "the step's summary lacks the recording"
    line = re.search(r"^::error file=crash/gate.toml,line=(\d+)", said, re.MULTILINE)
    assert bool(line) == bool(failed), said
    assert (temp / "latchgate-store").exists() == (inputs["cache"] != "false"), "the store is kept against the cache's word"
    return failed


def gitlab(pipeline, place):
    template = yaml.safe_load((place / pipeline["include"][0]["local"]).read_text())[pipeline["latch"]["extends"]]
    variables = {name: str(value) for name, value in (template["variables"] | pipeline["latch"]["variables"]).items()}
    code, _ = shell(place, "\n".join(template["before_script"] + template["script"]), variables)
    after, out = shell(place, "\n".join(template["after_script"]), variables)
    assert after == 0 and "burst.csv" in out, "the job's log lacks the summary"
    paths = template["cache"]["paths"] + template["artifacts"]["paths"] + [template["artifacts"]["reports"]["junit"]]
    for path in paths:
        path = re.sub(r"\$(\w+)", lambda found: variables[found[1]], path)
        assert (place / path).exists(), f"{path} is not there"
    return code


def jenkins(stage, place):
    code = 0
    for command in re.findall(r"sh '(.*?)'", stage):
        code = code or shell(place, command, {})[0]
    for path in ["gate/junit.xml", "gate/summary.json"]:
        assert (place / path).exists(), f"{path} is not there"
    return code


main()

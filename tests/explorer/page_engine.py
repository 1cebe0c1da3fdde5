"""The engine of the explorer's page, run by Node: texts of modules, systems and messages in, answers out."""

# ruff: noqa: E501 (lines of JavaScript)

import json
import shutil
import subprocess

import numpy as np
import pytest

from fastaff import schemes
from fastaff.explorer.page import script, worker_text
from fastaff.explorer.parameters import parameter_values
from fastaff.explorer.records import model_code
from fastaff.explorer.setup import frames, scheme_record, section_record
from fastaff.systems.models.mechanics import system_of

NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="there is no node here to run the page's engine")
BCE8 = schemes.BLANES_CASAS_ESCORIHUELA8

DRIVER = """
const plain = (key, value) => (ArrayBuffer.isView(value) ? Array.from(value, (x) => (Number.isFinite(x) ? x : null)) : value);
const everything = TASKS.map(({ text, messages, launches }) => {
  const heard = [], self = { postMessage: (message) => heard.push(message) };
  new Function("self", text)(self);
  for (const message of messages) self.onmessage({ data: message });
  return { heard, launches };
});
const ended = ({ heard, launches }) => heard.filter((m) => m.type === "refused" || m.type === "wrong"
  || (m.type === "reading" && m.status !== "running")).length >= launches;
const watch = setInterval(() => {
  if (!everything.every(ended)) return;
  clearInterval(watch);
  require("fs").writeFileSync(1, JSON.stringify(everything.map(({ heard }) => heard), plain));
  process.exit(0);
}, 2);
"""


def node(text, time=600):
    """What Node prints of a program, as JSON holds it."""
    done = subprocess.run([NODE, "-"], input=text, capture_output=True, text=True, timeout=time)
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout)


def compute(expression, *modules):
    """The value of an expression of JavaScript with the names of some modules."""
    texts = "\n".join(map(script, modules))
    return node(f"{texts}\nprocess.stdout.write(JSON.stringify({expression}));")


def system_message(body, accuracy=1e-11, scheme=BCE8):
    """The first message to a worker."""
    n = body.degrees_of_freedom
    system = {"parameters": parameter_values(body), "coordinates": list(body.coordinates)}
    record = scheme_record(scheme)
    return {"type": "system", "system": system, "accuracy": accuracy, "scheme": record, "frame": frames()[str(n)]}


def surface_message(body, section, energy, p_eta=0.0, p_gamma=0.0, width=40, height=30):
    """The message that chooses a section of an energy surface."""
    where = {"energy": energy, "p_eta": p_eta, "p_gamma": p_gamma, "width": width, "height": height}
    return {"type": "surface", **where, **section_record(section, system_of(body))}


def launch_message(orbit, point, crossings):
    return {"type": "launch", "orbit": orbit, "point": list(map(float, point)), "crossings": crossings}


def explored(tasks):
    """The answers to messages, for each of (code of a system, messages): all messages of each."""
    system = script("system.js")
    codes = json.dumps([code for code, _ in tasks])
    texts = node(f"{system}\nprocess.stdout.write(JSON.stringify({codes}.map(systemText)));")
    ready = [
        {
            "text": f"{worker_text()}\n{text}\nserve(compiledSystem);",
            "messages": messages,
            "launches": max(1, sum(m["type"] == "launch" for m in messages)) if _launches(messages) else 0,
        }
        for text, (_, messages) in zip(texts, tasks, strict=True)
    ]
    return node(f"const TASKS = {json.dumps(ready)};\n{DRIVER}")


def _launches(messages):
    return any(m["type"] == "launch" for m in messages)


def of(heard, kind, orbit=None):
    """The messages of a kind, of one orbit."""
    return [m for m in heard if m["type"] == kind and (orbit is None or m.get("orbit") == orbit)]


def crossings(heard, orbit=1):
    """Times (crossings,) and points (2, crossings) of an orbit."""
    parts = of(heard, "points", orbit)
    times = np.concatenate([m["times"] for m in parts]) if parts else np.zeros(0)
    points = np.concatenate([m["points"] for m in parts]) if parts else np.zeros(0)
    return times, points.reshape(-1, 2).T


def own_points(found, body, section):
    """The section coordinates (2, crossings) of the first orbit of a SectionMap, as the page has them."""
    if not system_of(body).isotropic:
        other = 1 - int(np.flatnonzero(section.normal)[0])
        return found.points[[other, 2 + other], :, 0]
    alpha = type(section).__name__.startswith("Beta")
    return np.array([found[name][:, 0] for name in (("alpha", "p_alpha") if alpha else ("beta", "p_beta"))])


def code_of(body):
    return model_code(system_of(body))

"""The examples of docs/integrator.md, by the client that openapi-python-client makes of /api/v1/openapi.json.

client.py BASE FOLDER: the farm, and the folder with hinge.stl and cover.stl.
"""

import io
import pathlib
import sys
import time

import httpx
from nestd_client import Client, models
from nestd_client.api import default as api
from nestd_client.api.default import (
    build, builds, content, delete_line, farm, line, order, orders, parts, patch_line, patch_order, patch_upload, plan, post_content,
    post_flush, post_lines, post_order, post_outcome, post_quote, post_upload, upload,
)
from nestd_client.types import File

base, folder = sys.argv[1], pathlib.Path(sys.argv[2])
# What is answered otherwise than it is described is an error.
client = Client(base_url=base, raise_on_unexpected_status=True)


def stl(name):
    return File(payload=io.BytesIO((folder / name).read_bytes()), file_name=name, mime_type="model/stl")


def patiently(ask, *told, **named):
    """Asks again when the farm says that something is under way, as curl does with --retry."""
    for _ in range(60):
        answer = ask.sync_detailed(*told, client=client, **named)
        if answer.status_code != 429:
            assert answer.status_code < 300, answer.content
            return answer.parsed
        time.sleep(1)
    raise TimeoutError(answer.content)


def in_words(told, words=""):
    """Whether it is done and told in words; a busy daemon notes it, and does it when it comes to it."""
    return not told.done or all(len(answer) > 1 and words in answer for answer in told.answers)


def until(what, is_true):
    for _ in range(120):
        if is_true():
            return
        time.sleep(0.5)
    raise TimeoutError(what)


assert "test" in [machine.machine for machine in patiently(farm).machines]

# Order: with its files, twice under the same key.
asked = models.OrderRequest.from_dict({
    "machine": "test", "order": "K-4711", "customer": "Brandt", "due": "2027-03-01",
    "lines": [{"name": "hinge.stl", "copies": 3, "orientation": "upright"}, {"name": "cover.stl"}],
})
first, again = (
    patiently(post_order, body=models.PostOrderFilesBody(order=asked, file=[stl("hinge.stl"), stl("cover.stl")]),
              idempotency_key="shop-4711")
    for _ in range(2)
)
assert first == again and [taken.copies for taken in first.lines] == [3, 1], again

# Files first, and then JSON alone.
put = patiently(post_content, body=stl("hinge.stl"))
assert patiently(content, put.content).content == put.content
left = {"name": "hinge-left.stl", "content": put.content, "copies": 2, "priority": 80,
        "keep_up": [{"direction": [0, 0, 1], "within_deg": 45}], "not_down": [{"direction": [1, 0, 0], "spare_deg": 10}]}
lines = patiently(post_lines, "K-4711", body=models.OrderRequest.from_dict({"machine": "test", "lines": [left]}),
                  idempotency_key="shop-4712")
assert patiently(line, "K-4711", lines.lines[0].line).line == lines.lines[0].line

# Change, cancel.
until("all lines are parts", lambda: [part.state for part in patiently(parts)].count("waiting") == 3)
seen = patiently(order, "K-4711")
assert len(seen.lines) == 3 and seen.wanted == 6 and seen.arriving == [], seen
assert "K-4711" in [summary.name for summary in patiently(orders, find="K-4711", state=models.OrderState.OPEN)]
number = {one.name: one.part for one in seen.lines}
changed = patiently(patch_order, "K-4711", body=models.EditRequest.from_dict({"due": "2027-02-15", "priority": 90}))
assert in_words(changed), changed
changed = patiently(patch_line, "K-4711", str(number["hinge.stl"]), body=models.EditRequest(copies=5))
assert in_words(changed, "5"), changed
assert in_words(patiently(delete_line, "K-4711", str(number["cover.stl"])))

# What is to come.
assert "test" in [machine.machine for machine in patiently(plan)]
quoted = models.OrderRequest.from_dict({"machine": "test", "due": "2027-03-01", "lines": [{"name": "hinge.stl", "copies": 2}]})
patiently(post_quote, body=models.PostQuoteFilesBody(quote=quoted, file=[stl("hinge.stl")]))

# Builds and machines.
assert in_words(patiently(post_flush, "test"))
until("a build is published", lambda: "published" in [one.state for one in patiently(builds)])
until("its printer has taken it", lambda: patiently(build, 1).build.taken_at)
bad = models.OutcomeRequestBad.from_dict({str(number["hinge.stl"]): 1})
told = patiently(post_outcome, 1, body=models.OutcomeRequest(outcome=models.OutcomeRequestOutcome.COMPLETE, bad=bad, note="warped"))
assert told.done and "Build 1 is complete." in told.answers, told

# Large files.
cover = (folder / "cover.stl").read_bytes()
tus = models.PostUploadTusResumable("1.0.0")
begun = post_upload.sync_detailed(client=client, tus_resumable=tus, upload_length=len(cover))
assert begun.status_code == 201, begun.content
name = begun.headers["location"].rsplit("/", 1)[1]
for offset, end in [(0, 40), (40, len(cover))]:
    sent = patch_upload.sync_detailed(name, client=client, body=File(payload=io.BytesIO(cover[offset:end])),
                                      tus_resumable=models.PatchUploadTusResumable("1.0.0"), upload_offset=offset)
    assert sent.status_code == 204, sent.content
assert patiently(upload, name).content, "the upload is complete"

# What is refused is described, too.
refused = order.sync_detailed("nobody", client=client)
assert refused.status_code == 404 and isinstance(refused.parsed, models.Problem), refused
print("all examples ran")

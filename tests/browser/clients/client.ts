// The examples of docs/integrator.md, by the types that openapi-typescript makes of /api/v1/openapi.json.
// node client.js BASE FOLDER: the farm, and the folder with hinge.stl and cover.stl.
import { readFileSync } from "node:fs";
import createClient from "openapi-fetch";
import type { components, paths } from "./nestd.js";

const [base, folder] = process.argv.slice(2) as [string, string];
const farm = createClient<paths>({ baseUrl: base });
const bytes = (name: string) => new Blob([readFileSync(`${folder}/${name}`)]);
const pause = (ms: number) => new Promise((done) => setTimeout(done, ms));

function check(holds: unknown, what: unknown): asserts holds {
  if (!holds) throw new Error(JSON.stringify(what));
}

/** Asks again when the farm says that something is under way, as curl does with --retry. */
async function patiently<T>(ask: () => Promise<{ data?: T; error?: unknown; response: Response }>): Promise<T> {
  for (let tries = 0; tries < 60; tries++) {
    const { data, error, response } = await ask();
    if (response.status !== 429) {
      check(response.ok && data !== undefined, error);
      return data;
    }
    await pause(1000);
  }
  throw new Error("the farm is busy for a minute");
}

/** Whether it is done and told in words; a busy daemon notes it, and does it when it comes to it. */
const inWords = (told: components["schemas"]["Carried"], words = "") => !told.done || told.answers.every((answer) => answer.length > 1 && answer.includes(words));

async function until(what: string, holds: () => Promise<boolean>) {
  for (let tries = 0; tries < 120; tries++) {
    if (await holds()) return;
    await pause(500);
  }
  throw new Error(what);
}

const seen = await patiently(() => farm.GET("/api/v1/farm"));
check(seen.machines.some((machine) => machine.machine === "test"), seen);

// Order: with its files, twice under the same key.
const order: components["schemas"]["OrderRequest"] = {
  machine: "test", order: "K-4711", customer: "Brandt", due: "2027-03-01",
  lines: [{ name: "hinge.stl", copies: 3, orientation: "upright" }, { name: "cover.stl" }],
};
const withFiles = () => farm.POST("/api/v1/orders", {
  params: { header: { "Idempotency-Key": "shop-4711" } },
  body: order,
  bodySerializer: (body) => {
    const form = new FormData();
    form.append("order", JSON.stringify(body));
    for (const name of ["hinge.stl", "cover.stl"]) form.append("file", bytes(name), name);
    return form;
  },
});
const first = await patiently(withFiles), again = await patiently(withFiles);
check(JSON.stringify(first) === JSON.stringify(again) && first.lines.map((line) => line.copies).join() === "3,1", again);

// Files first, and then JSON alone.
const octets = { bodySerializer: (body: unknown) => body as Blob, headers: { "Content-Type": "application/octet-stream" } };
const put = await patiently(() => farm.POST("/api/v1/content", { body: bytes("hinge.stl") as unknown as string, ...octets }));
const known = await patiently(() => farm.GET("/api/v1/content/{hash}", { params: { path: { hash: put.content } } }));
check(known.content === put.content, known);
const added = await patiently(() => farm.POST("/api/v1/orders/{order}/lines", {
  params: { path: { order: "K-4711" }, header: { "Idempotency-Key": "shop-4712" } },
  body: { machine: "test", lines: [{ name: "hinge-left.stl", content: put.content, copies: 2, priority: 80,
    keep_up: [{ direction: [0, 0, 1], within_deg: 45 }], not_down: [{ direction: [1, 0, 0], spare_deg: 10 }] }] },
}));
const line = { order: "K-4711", line: added.lines[0]!.line };
check((await patiently(() => farm.GET("/api/v1/orders/{order}/lines/{line}", { params: { path: line } }))).line === line.line, line);

// Change, cancel.
const waiting = async () => (await patiently(() => farm.GET("/api/v1/parts", { params: { query: { state: "waiting" } } }))).length;
await until("all lines are parts", async () => (await waiting()) === 3);
const path = { order: "K-4711" };
const detail = await patiently(() => farm.GET("/api/v1/orders/{order}", { params: { path } }));
check(detail.lines.length === 3 && detail.wanted === 6 && detail.arriving.length === 0, detail);
const numbered = (name: string) => ({ order: "K-4711", line: String(detail.lines.find((one) => one.name === name)!.part) });
const changed = await patiently(() => farm.PATCH("/api/v1/orders/{order}", { params: { path }, body: { due: "2027-02-15", priority: 90 } }));
check(inWords(changed), changed);
const copies = await patiently(() => farm.PATCH("/api/v1/orders/{order}/lines/{line}", { params: { path: numbered("hinge.stl") }, body: { copies: 5 } }));
check(inWords(copies, "5"), copies);
check(inWords(await patiently(() => farm.DELETE("/api/v1/orders/{order}/lines/{line}", { params: { path: numbered("cover.stl") } }))), "cancelled");

// What is to come.
check((await patiently(() => farm.GET("/api/v1/plan"))).some((plan) => plan.machine === "test"), "plan");
await patiently(() => farm.POST("/api/v1/quote", { body: { machine: "test", due: "2027-03-01", lines: [{ name: "hinge.stl", content: put.content, copies: 2 }] } }));

// Builds and machines.
check(inWords(await patiently(() => farm.POST("/api/v1/machines/{machine}/flush", { params: { path: { machine: "test" } } }))), "flush");
const published = async () => (await patiently(() => farm.GET("/api/v1/builds"))).some((build) => build.state === "published");
await until("a build is published", published);
await until("its printer has taken it", async () => !!(await patiently(() => farm.GET("/api/v1/builds/{build}", { params: { path: { build: 1 } } }))).build.taken_at);
const told = await patiently(() => farm.POST("/api/v1/builds/{build}/outcome", {
  params: { path: { build: 1 } }, body: { outcome: "complete", bad: { [numbered("hinge.stl").line]: 1 }, note: "warped" },
}));
check(told.done && told.answers.includes("Build 1 is complete."), told);

// Large files.
const cover = readFileSync(`${folder}/cover.stl`);
const begun = await farm.POST("/api/v1/uploads", { params: { header: { "Tus-Resumable": "1.0.0", "Upload-Length": cover.length } } });
check(begun.response.status === 201, begun.error);
const upload = begun.response.headers.get("location")!.split("/").pop()!;
for (const [from, to] of [[0, 40], [40, cover.length]] as const) {
  const sent = await farm.PATCH("/api/v1/uploads/{upload}", {
    params: { path: { upload }, header: { "Tus-Resumable": "1.0.0", "Upload-Offset": from } },
    body: new Blob([cover.subarray(from, to)]) as unknown as string,
    bodySerializer: (body) => body, headers: { "Content-Type": "application/offset+octet-stream" },
  });
  check(sent.response.status === 204, sent.error);
}
check((await patiently(() => farm.GET("/api/v1/uploads/{upload}", { params: { path: { upload } } }))).content, "the upload is complete");

// What is refused is described, too.
const refused = await farm.GET("/api/v1/orders/{order}", { params: { path: { order: "nobody" } } });
check(refused.response.status === 404 && refused.error?.detail, refused.error);
console.log("all examples ran");

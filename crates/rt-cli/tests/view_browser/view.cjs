// Uses the page of `rt-cli view` in a real browser, as a person would.
//
// The folder gets screenshots, the pixels of the canvas, and the saved files.

"use strict";

const assert = require("node:assert/strict");
const fs = require("node:fs");
const { cameraText, drag, file, middle, moves, open, rendersAnew, run, step } = require("./page.cjs");

/** Samples per pixel of the command line. */
const SPP = 24;

async function onTheDesktop(browser) {
  const { page, problems } = await open(browser, { viewport: { width: 1280, height: 800 } });
  // So many samples that the render lasts, and then those of the command line.
  const samples = (spp) =>
    page.evaluate((spp) => fetch("settings", { method: "POST", body: JSON.stringify({ spp }) }).then((r) => r.ok), spp);
  assert(await samples(1 << 16), "the number of samples cannot be set");
  await page.waitForFunction(
    () => document.body.dataset.state === "rendering" && document.querySelectorAll("#plot .line").length > 0,
  );
  await page.screenshot({ path: file("rendering.png") });
  step("an image while it is rendered");

  await rendersAnew(page, () => samples(SPP));
  const pixels = await page.evaluate(() => {
    const { width, height } = document.getElementById("image");
    const { data } = document.getElementById("image").getContext("2d").getImageData(0, 0, width, height);
    return { width, height, data: [...data] };
  });
  fs.writeFileSync(file("pixels.json"), JSON.stringify(pixels));
  const points = await page.evaluate(() => document.querySelector("#plot .line").getAttribute("d").split("L").length);
  assert(points >= 4, `the plot has ${points} points`);
  await page.locator("figure").screenshot({ path: file("error_plot.png") });
  for (const name of ["PNG", "EXR"]) {
    const download = page.waitForEvent("download");
    await page.getByRole("link", { name: `Save ${name}` }).click();
    await (await download).saveAs(file(`saved.${name.toLowerCase()}`));
  }
  step("finished, plotted, and saved");

  // The lower part of the left wall.
  const { x, y, width, height } = await middle(page);
  await page.mouse.click(x - 0.42 * width, y + 0.1 * height);
  await page.waitForSelector("#pick:not([hidden])");
  await page.waitForSelector("#marker:not([hidden])");
  const picked = await page.locator("#pick").innerText();
  fs.writeFileSync(file("pick.txt"), picked);
  await page.screenshot({ path: file("pick.png") });
  step("picked");

  await page.getByRole("button", { name: "Copy camera" }).click();
  await page.waitForFunction(() => document.getElementById("toast").textContent.includes("copied"));
  const copied = await page.evaluate(() => navigator.clipboard.readText());
  assert.equal(copied, await cameraText(page));
  assert(copied.startsWith("camera: ("), copied);
  const unmoved = copied;

  await moves(page, "a drag", () => drag(page, "left", [60, 20]));
  await moves(page, "a right drag", () => drag(page, "right", [30, 10]));
  await moves(page, "a middle drag", () => drag(page, "middle", [30, 10]));
  await moves(page, "a drag with Shift", () => drag(page, "left", [30, 10], "Shift"));
  await moves(page, "the wheel", () => page.mouse.wheel(0, -240));
  await moves(page, "an arrow key", () => page.keyboard.press("ArrowRight"));
  await moves(page, "a key of flight", () => page.keyboard.press("w", { delay: 120 }));
  await moves(page, "plus", () => page.keyboard.press("+"));
  await moves(page, "F", () => page.keyboard.press("f"));
  assert.equal(await moves(page, "R", () => page.keyboard.press("r")), unmoved);
  step("moved and reset");

  await page.keyboard.press("h");
  await page.waitForSelector("#help[open]");
  await page.screenshot({ path: file("help.png") });
  await page.keyboard.press("Escape");
  await page.waitForSelector("#help:not([open])", { state: "attached" });

  await rendersAnew(page, () => page.getByLabel("Integrator").selectOption("normals"));
  await page.screenshot({ path: file("normals.png") });
  await page.getByLabel("Tone curve").selectOption("aces");
  await page.getByLabel("Exposure").fill("1");
  await page.waitForFunction(() => document.getElementById("exposure-value").textContent === "1.0 EV");
  await rendersAnew(page, () => page.getByLabel("Samples", { exact: true }).selectOption("1"));
  await rendersAnew(page, () => page.getByLabel("Resolution").selectOption("half"));
  const isHalf = () => document.getElementById("image").width === Math.round(document.getElementById("stage").clientWidth / 2);
  assert(await page.evaluate(isHalf), "half of the window");
  await rendersAnew(page, () => page.getByLabel("Integrator").selectOption("path"));
  await page.screenshot({ path: file("settings.png") });
  assert.deepEqual(problems, []);
  await page.context().close();
  step("settings changed");
}

async function onAPhone(browser) {
  const { page, problems } = await open(browser, {
    viewport: { width: 390, height: 780 },
    deviceScaleFactor: 2,
    hasTouch: true,
    isMobile: true,
  });
  await rendersAnew(page, () => page.getByLabel("Resolution").selectOption("window"));
  const overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  assert.equal(overflow, 0, "the page is wider than the screen");
  const session = await page.context().newCDPSession(page);
  const touch = (type, ...at) => session.send("Input.dispatchTouchEvent", { type, touchPoints: at.map(([x, y], id) => ({ x, y, id })) });
  const { x, y } = await middle(page);
  await moves(page, "one finger", async () => {
    await touch("touchStart", [x, y]);
    await touch("touchMove", [x + 20, y]);
    await touch("touchMove", [x + 50, y + 10]);
    await touch("touchEnd");
  });
  await moves(page, "two fingers", async () => {
    await touch("touchStart", [x - 20, y], [x + 20, y]);
    await touch("touchMove", [x - 40, y], [x + 40, y]);
    await touch("touchMove", [x - 70, y], [x + 70, y]);
    await touch("touchEnd");
  });
  await page.touchscreen.tap(x, y);
  await page.waitForSelector("#marker:not([hidden])");
  await rendersAnew(page, () => page.getByRole("button", { name: "Reset camera" }).click());
  await page.screenshot({ path: file("phone.png") });
  // From here on there is work without end, until the page is closed.
  await page.getByLabel("Samples", { exact: true }).selectOption("no limit");
  await page.waitForSelector("body[data-state=rendering]");
  assert.deepEqual(problems, []);
  await page.context().close();
  step("touched");
}

run(onTheDesktop, onAPhone);

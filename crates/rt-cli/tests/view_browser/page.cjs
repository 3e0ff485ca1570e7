// A browser with the page of `rt-cli view`, for scripts that are started as
//
//     node SCRIPT.cjs ADDRESS CHROMIUM FOLDER

"use strict";

const assert = require("node:assert/strict");
const fs = require("node:fs");
const path = require("node:path");
const { chromium } = require("playwright-core");

const [address, executablePath, folder] = process.argv.slice(2);
const PATIENCE = 60_000;
const FLAGS = [
  "--no-sandbox",
  "--disable-gpu",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
];

const file = (name) => path.join(folder, name);
const started = Date.now();
const step = (name) => console.log(`${((Date.now() - started) / 1000).toFixed(1)} s: ${name}`);

/** A page that fails the test if it reports an error, or asks anyone but the program. */
async function open(browser, options) {
  const context = await browser.newContext({ acceptDownloads: true, ...options });
  await context.grantPermissions(["clipboard-read", "clipboard-write"]);
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  const problems = [];
  page.on("pageerror", (error) => problems.push(String(error)));
  page.on("console", (message) => message.type() === "error" && problems.push(message.text()));
  page.on("request", (request) => {
    const isOurs = request.url().startsWith(address) || /^(blob|data):/.test(request.url());
    if (!isOurs) problems.push(`a request to ${request.url()}`);
  });
  await page.goto(address);
  return { page, problems };
}

/** Does something that has to change the image, and waits until the new one is finished. */
async function rendersAnew(page, action) {
  const before = await page.getAttribute("body", "data-view");
  await action();
  await page.waitForFunction((before) => document.body.dataset.view !== before && document.body.dataset.state === "finished", before);
}

const cameraText = (page) => page.evaluate(async () => (await fetch("camera")).text());

/** Does something that has to move the camera, and returns the camera as text. */
async function moves(page, what, action) {
  const before = await cameraText(page);
  await action();
  const deadline = Date.now() + PATIENCE;
  for (;;) {
    const now = await cameraText(page);
    if (now !== before) return now;
    assert(Date.now() < deadline, `${what} moves nothing`);
  }
}

async function drag(page, button, by, modifier) {
  const { x, y } = await middle(page);
  if (modifier) await page.keyboard.down(modifier);
  await page.mouse.move(x, y);
  await page.mouse.down({ button });
  await page.mouse.move(x + by[0], y + by[1], { steps: 4 });
  await page.mouse.up({ button });
  if (modifier) await page.keyboard.up(modifier);
}

async function middle(page) {
  const box = await page.locator("#image").boundingBox();
  return { x: box.x + box.width / 2, y: box.y + box.height / 2, width: box.width, height: box.height };
}

/** Runs these functions of a browser one after the other. */
async function run(...parts) {
  const profile = fs.mkdtempSync(file("profile-"));
  const browser = await chromium.launch({ executablePath, args: FLAGS, headless: true, env: { ...process.env, HOME: profile } });
  try {
    for (const part of parts) await part(browser);
  } catch (error) {
    console.error(error);
    process.exitCode = 1;
  } finally {
    await browser.close();
    fs.rmSync(profile, { recursive: true, force: true });
  }
}

module.exports = { cameraText, drag, file, middle, moves, open, rendersAnew, run, step };

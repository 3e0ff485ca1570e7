// The menu Resolution shows the size that the server has. The size of the scene is 80 × 60.

"use strict";

const assert = require("node:assert/strict");
const { open, rendersAnew, run, step } = require("./page.cjs");

const viewport = { width: 1000, height: 700 };

/** Waits until the menu shows this choice, and the image has the size of it. */
async function shows(page, choice, size) {
  await page.waitForFunction(
    ([choice, size]) => {
      const [list, image, stage] = ["size", "image", "stage"].map((id) => document.getElementById(id));
      const expected = size ?? [stage.clientWidth, stage.clientHeight];
      const isSize = image.width === expected[0] && image.height === expected[1];
      return list.selectedOptions[0].text.startsWith(choice) && isSize;
    },
    [choice, size],
  );
}

const choose = (page, choice) => rendersAnew(page, () => page.getByLabel("Resolution").selectOption(choice));

async function theMenuFollowsTheServer(browser) {
  const { page, problems } = await open(browser, { viewport });
  await shows(page, "Scene, 80 × 60", [80, 60]);
  await choose(page, "window");
  await shows(page, "Window");
  const windowSize = await page.evaluate(() => [document.getElementById("image").width, document.getElementById("image").height]);
  step("window chosen");

  await page.reload();
  await shows(page, "Window");
  await page.setViewportSize({ width: 900, height: 650 });
  await shows(page, "Window");
  await page.setViewportSize(viewport);
  await shows(page, "Window", windowSize);
  step("reloaded, and resized");

  // A window of another size shows the size, and does not change it.
  const other = await open(browser, { viewport: { width: 800, height: 600 } });
  await shows(other.page, windowSize.join(" × "), windowSize);
  await other.page.setViewportSize({ width: 820, height: 600 });
  await other.page.waitForTimeout(1000);
  await shows(other.page, windowSize.join(" × "), windowSize);
  await choose(other.page, "scene");
  await shows(other.page, "Scene", [80, 60]);
  await shows(page, "Scene", [80, 60]);
  assert.deepEqual(other.problems, []);
  await other.page.context().close();
  step("chosen in another window");

  await choose(page, "half");
  await page.reload();
  await page.waitForFunction(() => document.getElementById("size").value === "half");
  await choose(page, "scene");
  await shows(page, "Scene", [80, 60]);
  assert.deepEqual(problems, []);

  // More pixels than the server allows.
  await page.setViewportSize({ width: 5000, height: 3000 });
  await page.getByLabel("Resolution").selectOption("window");
  await page.waitForFunction(() => document.getElementById("toast").textContent.includes("at most 8294400 pixels"));
  await shows(page, "Scene", [80, 60]);
  await page.context().close();
  step("refused");
}

run(theMenuFollowsTheServer);

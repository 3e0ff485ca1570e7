// Keys on keyboards with other layouts. The events are those of a browser: `code` is the place on a US keyboard, `key` the letter.

"use strict";

const assert = require("node:assert/strict");
const { cameraText, moves, open, run, step } = require("./page.cjs");

const press = (page, code, key) =>
  page.evaluate(
    ([code, key]) => {
      for (const type of ["keydown", "keyup"]) document.body.dispatchEvent(new KeyboardEvent(type, { code, key, bubbles: true }));
    },
    [code, key],
  );

async function actionsFollowTheLettersOfAllLayouts(browser) {
  const { page, problems } = await open(browser, { viewport: { width: 1000, height: 700 } });
  const unmoved = await cameraText(page);
  const resets = async (layout, code, key) => {
    await moves(page, "an arrow key", () => page.keyboard.press("ArrowRight"));
    await page.waitForFunction(async (text) => (await (await fetch("camera")).text()) !== text, unmoved);
    assert.equal(await moves(page, `${key} (${layout})`, () => press(page, code, key)), unmoved, `${layout}: ${key}`);
  };
  await resets("US", "KeyR", "r");
  await resets("US with Shift", "KeyR", "R");
  await resets("Cyrillic", "KeyR", "к");
  await resets("Greek", "KeyR", "ρ");
  await resets("Colemak", "KeyS", "r");
  await resets("Dvorak", "KeyO", "r");
  step("reset");

  for (const [layout, code, key] of [["Cyrillic", "KeyH", "р"], ["Dvorak", "KeyJ", "h"]]) {
    await press(page, code, key);
    assert(await page.evaluate(() => document.getElementById("help").open), `${layout}: ${key}`);
    await page.evaluate(() => document.getElementById("help").close());
  }
  for (const [code, key] of [["KeyW", "ц"], ["KeyW", "z"], ["KeyA", "q"], ["KeyD", "e"], ["KeyQ", "'"]]) {
    await moves(page, `${key} at ${code}`, () => press(page, code, key));
  }
  step("flown by place");

  // Letters without an action at the places of actions.
  const before = await cameraText(page);
  for (const [code, key] of [["KeyR", "p"], ["KeyH", "d"], ["KeyC", "j"]]) await press(page, code, key);
  await page.waitForTimeout(500);
  assert.equal(await cameraText(page), before);
  assert(!(await page.evaluate(() => document.getElementById("help").open)), "Dvorak: D");
  assert.deepEqual(problems, []);
  await page.context().close();
  step("nothing done");
}

run(actionsFollowTheLettersOfAllLayouts);

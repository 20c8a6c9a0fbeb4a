// The report in a real browser: node report.js FOLDER [PICTURES]. FOLDER has report.html; pictures of the page are kept where asked for.
"use strict";
const { chromium } = require("playwright-core");
const { execFileSync } = require("child_process");
const fs = require("fs");
const os = require("os");
const path = require("path");

const [folder, pictures] = process.argv.slice(2).map((name) => path.resolve(name));
const failures = [];
const check = (holds, what) => { if (!holds) failures.push(what); };

// Words of one figure that cover each other or leave it.
const overlaps = () => {
  const found = [];
  for (const svg of document.querySelectorAll("svg.figure")) {
    const edge = svg.getBoundingClientRect();
    if (edge.width === 0) continue;
    const words = [...svg.querySelectorAll("text")].map((text) => [text, text.getBoundingClientRect()]);
    const name = svg.closest("figure")?.id;
    for (const [text, box] of words) {
      if (box.left < edge.left - 1 || box.right > edge.right + 1 || box.bottom > edge.bottom + 1) found.push(`${name}: "${text.textContent}" leaves the figure`);
    }
    words.forEach(([text, a], index) => {
      for (const [other, b] of words.slice(index + 1)) {
        const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left), high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        if (wide > 1 && high > 3) found.push(`${name}: "${text.textContent}" covers "${other.textContent}"`);
      }
    });
  }
  return found;
};

async function view(browser, width, colorScheme) {
  const name = `${width} px, ${colorScheme}`;
  const page = await browser.newPage({ viewport: { width, height: 900 }, colorScheme });
  page.on("console", (message) => check(false, `${name}: console: ${message.text()}`));
  page.on("pageerror", (error) => check(false, `${name}: script: ${error.message}`));
  page.on("request", (request) => check(/^(file|data):/.test(request.url()), `${name}: fetches ${request.url()}`));
  await page.goto("file://" + path.join(folder, "report.html"));
  check(!(await page.evaluate(() => document.documentElement.scrollWidth > innerWidth)), `${name}: the page is wider than the window`);
  if (pictures) await page.screenshot({ path: path.join(pictures, `${width}-${colorScheme}.png`), fullPage: true, timeout: 120000 });
  return [name, page];
}

async function accessible(name, page) {
  await page.evaluate(fs.readFileSync(require.resolve("axe-core/axe.min.js"), "utf8"));
  const { violations } = await page.evaluate(() => axe.run());
  for (const { id, nodes } of violations) check(false, `${name}: axe: ${id}, ${nodes.length} times: ${nodes[0].html.slice(0, 160)}`);
}

// Hover, keyboard and the chooser, as a person uses them.
async function used(name, page) {
  const visible = "svg.figure:visible";
  // The point with most room around it: the nearest one speaks, whichever line is drawn over it.
  const points = page.locator(visible).filter({ has: page.locator(".point") }).first().locator(".point");
  const alone = await points.evaluateAll((all) => {
    const room = (one) => Math.min(...all.filter((other) => other !== one).map((other) => Math.hypot(other.dataset.x - one.dataset.x, other.dataset.y - one.dataset.y)));
    return all.indexOf(all.reduce((a, b) => (room(b) > room(a) ? b : a)));
  });
  await points.nth(alone).hover({ force: true });
  check((await page.locator("#tip").textContent()) === (await points.nth(alone).getAttribute("aria-label")), `${name}: hovering does not tell the point`);
  await points.first().focus();
  await page.keyboard.press("ArrowRight");
  check((await page.locator("#tip").textContent()) === (await points.nth(1).getAttribute("aria-label")), `${name}: arrow keys do not lead on`);
  const stops = await page.locator(`${visible} .point[tabindex="0"]`).count();
  check(stops === await page.locator(visible).filter({ has: page.locator(".point") }).count(), `${name}: ${stops} stops of the tab key`);
  await page.keyboard.press("Escape");
  check(await page.locator("#tip").isHidden(), `${name}: Escape leaves the words there`);

  const choices = JSON.parse(await page.locator("#choices").textContent());
  const r = +(await page.locator("#want-r").inputValue());
  const here = choices.filter((choice) => choice.r_ohm === r);
  const error = [...here].sort((a, b) => a.error_ohm - b.error_ohm)[Math.floor(here.length / 2)].error_ohm * 1.0001;
  await page.fill("#want-error", String(error));
  const fastest = here.filter((choice) => choice.error_ohm <= error).reduce((a, b) => a.seconds <= b.seconds ? a : b);
  const answer = await page.locator("#chosen").textContent();
  const told = [fastest.name, `method = "${fastest.method}"`, String(+fastest.error_ohm.toPrecision(3))].every((part) => answer.includes(part));
  check(told, `${name}: the chooser says "${answer}", not ${fastest.name}`);
  await page.fill("#want-error", "2 kohm");
  check((await page.locator("#chosen").textContent()).includes("a number of ohm is wanted"), `${name}: 2 kohm is taken for a number`);
  await page.fill("#want-error", "2,5");
  check(!(await page.locator("#chosen").textContent()).includes("wanted"), `${name}: a comma is refused`);
  await page.fill("#want-rate", "1e9");
  check((await page.locator("#chosen").textContent()).startsWith("Nothing"), `${name}: a rate that nothing has is chosen`);
}

// The commands that the chooser names, run, give the errors and times that it said. CERMCTL: the program; AGAIN: words that were in
// the command of the report, so that the same instruments measure.
async function measuredAgain(name, page) {
  const choices = JSON.parse(await page.locator("#choices").textContent());
  const r = +(await page.locator("#want-r").inputValue());
  const own = choices.filter((choice) => choice.r_ohm === r && !choice.size).sort((a, b) => a.seconds - b.seconds);
  const run = new Set();
  for (const choice of [own[0], own[Math.floor(own.length / 2)], own[own.length - 1]]) {
    await page.fill("#want-error", String(choice.error_ohm * 1.001));
    await page.fill("#want-rate", String(0.999 / choice.seconds));
    const [answer, codes] = [await page.locator("#chosen").textContent(), await page.locator("#chosen code").allTextContents()];
    const command = codes.find((code) => code.startsWith("cermctl characterize "));
    if (!command || run.has(command)) continue;
    run.add(command);
    const folder = fs.mkdtempSync(path.join(os.tmpdir(), "again-"));
    execFileSync("sh", ["-c", `"$CERMCTL" ${command.slice("cermctl ".length)} ${process.env.AGAIN}`], { cwd: folder, stdio: ["ignore", "ignore", "inherit"] });
    const [names, values, ...more] = fs.readFileSync(path.join(folder, "again", "points.csv"), "utf8").trim().split("\n").map((line) => line.split(","));
    fs.rmSync(folder, { recursive: true });
    const value = (column) => +values[names.indexOf(column)];
    const rounded = (number) => String(+number.toPrecision(3));
    const seconds = value("published_s") / (1 - value("no_number") - value("moving"));
    const told = [`error ${rounded(value("rms_ohm"))} ohm`, `one reading in ${seconds >= 1 ? rounded(seconds) + " s" : rounded(1e3 * seconds) + " ms"}`];
    check(more.length === 0 && told.every((part) => answer.includes(part)), `${name}: "${answer}", but measured again ${told}`);
  }
  check(run.size > 1, `${name}: the chooser names ${run.size} commands`);
}

(async () => {
  const options = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"];
  const browser = await chromium.launch({ executablePath: process.env.CHROMIUM || "/usr/bin/chromium", args: options });
  // Each width and each scheme is looked at closely once.
  for (const [width, scheme, isClose] of [[1400, "light", true], [390, "dark", true], [1400, "dark", false], [390, "light", false]]) {
    const [name, page] = await view(browser, width, scheme);
    if (isClose) {
      for (const overlap of await page.evaluate(overlaps)) check(false, `${name}: ${overlap}`);
      await used(name, page);
      await accessible(name, page);
      if (process.env.CERMCTL && width > 1000) await measuredAgain(name, page);
    }
    await page.close();
  }
  const page = await browser.newPage();
  await page.goto("file://" + path.join(folder, "report.html"));
  const paper = await page.pdf({ format: "A4", path: pictures && path.join(pictures, "report.pdf") });
  check(paper.length > 10000, "nothing is printed");
  const figures = fs.readdirSync(path.join(folder, "figures")).filter((name) => name.endsWith(".svg"));
  check(figures.length > 0, "no figures as files");
  for (const name of figures) {
    await page.setContent(`<img alt="" src="data:image/svg+xml;base64,${fs.readFileSync(path.join(folder, "figures", name)).toString("base64")}">`);
    check(await page.evaluate(() => document.images[0].decode().then(() => document.images[0].naturalWidth > 300, () => false)), `${name} is no picture`);
  }
  await browser.close();
  for (const failure of failures) console.error("FAILED: " + failure);
  console.log(`report.html: ${failures.length} failures; 1400 and 390 px, light and dark, paper, ${figures.length} figures as files`);
  process.exit(failures.length ? 1 : 0);
})().catch((error) => { console.error(error); process.exit(1); });

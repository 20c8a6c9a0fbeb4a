// The page in a real browser. What must happen outside of it is asked for by a line; an answer means it has happened.
const { chromium } = require("playwright-core");
const readline = require("readline");

const [url, pictures] = process.argv.slice(2);
const answers = readline.createInterface({ input: process.stdin })[Symbol.asyncIterator]();
const ask = async (what) => { console.log(`do ${what}`); await answers.next(); };
let failed = false;
const check = (what, isSo, seen = "") => {
    console.log(`${isSo ? "ok" : "FAILED"}: ${what} ${seen}`);
    failed ||= !isSo;
};

(async () => {
    const browser = await chromium.launch({
        executablePath: "/usr/bin/chromium",
        args: ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update", "--no-first-run"],
    });
    const page = await browser.newPage({ viewport: { width: 1100, height: 760 }, colorScheme: "light" });
    const complaints = [];
    page.on("console", (message) => message.type() === "error" && complaints.push(message.text()));
    page.on("pageerror", (error) => complaints.push(error.message));
    // By the browser's debugger: the policy of the page forbids scripts of others.
    await page.addInitScript({ path: require.resolve("axe-core/axe.min.js") });
    await page.goto(url);
    const thumb = page.locator("[data-channel=thumb]"), index = page.locator("[data-channel=index]");
    const value = (channel) => channel.locator(".value").textContent();

    const looks = async (state) => {
        for (const [width, scheme] of [[1100, "light"], [1100, "dark"], [390, "light"], [390, "dark"]]) {
            await page.setViewportSize({ width, height: 760 });
            await page.emulateMedia({ colorScheme: scheme });
            const { violations } = await page.evaluate(() => axe.run());
            check(`${state}: axe at ${width}, ${scheme}`, violations.length === 0, violations.map((v) => `${v.id}: ${v.nodes[0].html}`).join("; "));
            const tooWide = await page.evaluate(() => document.documentElement.scrollWidth > innerWidth);
            check(`${state}: no wider than the window at ${width}`, !tooWide);
            if (pictures) await page.screenshot({ path: `${pictures}/web-${state}-${width}-${scheme}.png`, fullPage: true });
        }
    };

    await index.locator(".state", { hasText: /^ok$/ }).waitFor();
    check("a value with its uncertainty and unit", /^\d+(\.\d+)? ± \d+(\.\d+)? Ω$/.test(await value(index)), await value(index));
    const r = parseFloat(await value(index));
    check("it is that of the sensor", Math.abs(r - 2000) < 40, r);
    check("a force", / N$/.test(await value(thumb)), await value(thumb));
    const seen = new Set();
    for (let i = 0; i < 10; i++) { seen.add(await value(thumb)); await page.waitForTimeout(300); }
    check("values move", seen.size > 5, `${seen.size} in 10 looks`);
    await page.locator("#figures", { hasText: "latency offset" }).waitFor();
    await page.waitForTimeout(pictures ? 40000 : 4000);
    await index.locator(".span", { hasText: /, \d+(\.\d+)?\/s$/ }).waitFor();
    check("each channel has its own rate", true, await index.locator(".span").textContent());
    const drawn = await thumb.locator(".line").getAttribute("d");
    check("a plot is drawn, with its band", drawn.length > 500 && (await thumb.locator(".band").getAttribute("d")).length > 500, `${drawn.length} characters`);

    await looks("ok");

    await ask("break");
    await index.locator(".state.fault").waitFor();
    const state = await index.locator(".state").textContent();
    check("a fault shows, without a number", state.length > 0 && !/\d/.test(await value(index)), `${state}: ${await index.locator(".note").textContent()}`);
    await looks("fault");
    await ask("mend");
    await index.locator(".state.ok").waitFor();

    await ask("kill cermd");
    await page.locator("#link", { hasText: "does not answer" }).waitFor();
    check("an outage of cermd shows, without numbers", !/\d/.test(await value(index)), await index.locator(".state").textContent());
    await looks("away");
    await ask("start cermd");
    await index.locator(".state.ok").waitFor();
    check("it is back after a restart of cermd", true);

    complaints.length = 0;
    await ask("kill web");
    await page.locator("#link", { hasText: "trying again" }).waitFor();
    check("an outage of the page's server shows, without numbers", !/\d/.test(await value(index)));
    await ask("start web");
    await index.locator(".state.ok").waitFor();
    check("it is back after a restart of the server", true);
    // The attempts in between are told by the browser; nothing else may be.
    const others = complaints.filter((text) => !/ERR_CONNECTION_REFUSED|ERR_INCOMPLETE_CHUNKED|ERR_EMPTY_RESPONSE|ERR_CONNECTION_RESET/.test(text));
    check("nothing to complain of on the console", others.length === 0, others.join("; "));
    await browser.close();
    process.exit(failed ? 1 : 0);
})().catch((error) => { console.log(`FAILED: ${error.message}`); process.exit(1); });

// A picture of a page of Home Assistant, as somebody who is logged in.
const { chromium } = require("playwright-core");
const [url, tokens, picture] = process.argv.slice(2);

(async () => {
    const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu"] });
    const page = await browser.newPage({ viewport: { width: 1200, height: 800 } });
    await page.addInitScript((value) => localStorage.setItem("hassTokens", value), tokens);
    await page.goto(url);
    // Names stand without that of the device there.
    const shown = page.getByText(/thumb (force|resistance)/i).first().waitFor({ timeout: 120000 });
    const error = await shown.then(() => null, (error) => error);
    await page.waitForTimeout(3000);
    await page.screenshot({ path: picture, timeout: 60000 });
    if (error) throw error;
    await browser.close();
})().catch((error) => { console.log(error.message); process.exit(1); });

// Photographs a report in a real browser, and measures what a person would complain about.
//   cd scripts/viewer && npm ci && node ../screenshots.mjs REPORT.html OUTPUT_DIRECTORY [SCREEN,...]
// Desktop and phone, light and dark, every section; the 3D view turned, cut, recoloured and running; the printed PDF.
// Exit status 1 where a label leaves its plot, two labels overlap, the page is wider than the screen, or the console complains.
import { createRequire } from "node:module";
import { mkdirSync, mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const { chromium } = createRequire(new URL("./viewer/package.json", import.meta.url))("playwright-core");
const [report, out] = process.argv.slice(2, 4).map((p) => resolve(p));
if (!report || !out) throw new Error("usage: screenshots.mjs REPORT.html OUTPUT_DIRECTORY [SCREEN,...]");
const wanted = process.argv[4]?.split(",");
mkdirSync(out, { recursive: true });
const complaints = [];

const SCREENS = [
  { name: "desktop-light", width: 1280, height: 900, scheme: "light" },
  { name: "desktop-dark", width: 1280, height: 900, scheme: "dark" },
  { name: "phone-light", width: 390, height: 844, scheme: "light", touch: true },
  { name: "phone-dark", width: 390, height: 844, scheme: "dark", touch: true },
  { name: "tablet-light", width: 720, height: 1000, scheme: "light" },
  { name: "small-phone-light", width: 320, height: 640, scheme: "light", touch: true },
  { name: "without-webgl", width: 1280, height: 900, scheme: "light", flags: ["--disable-3d-apis"] },
  { name: "greyscale", width: 1280, height: 900, scheme: "light", grey: true },
];

for (const screen of SCREENS.filter(({ name }) => !wanted || wanted.includes(name))) {
  const context = await chromium.launchPersistentContext(mkdtempSync(join(tmpdir(), "camgeom-")), {
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    headless: true,
    offline: true,
    viewport: { width: screen.width, height: screen.height },
    deviceScaleFactor: screen.touch ? 2 : 1,
    hasTouch: Boolean(screen.touch),
    colorScheme: screen.scheme,
    args: [
      "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
      "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...(screen.flags ?? []),
    ],
  });
  const page = context.pages()[0] ?? (await context.newPage());
  const say = (what) => complaints.push(`${screen.name}: ${what}`);
  page.on("console", (m) => { if (["error", "warning"].includes(m.type()) && !/GPU stall|swiftshader/i.test(m.text()) && !screen.flags) say(`console: ${m.text()}`); });
  page.on("pageerror", (error) => say(`error: ${error.message}`));
  page.on("request", (request) => { if (!/^(file|data|blob):/.test(request.url())) say(`asks the network for ${request.url()}`); });
  page.on("dialog", async (dialog) => { say(`dialog: ${dialog.message()}`); await dialog.dismiss(); });
  await page.goto(pathToFileURL(report).href);
  const scene = page.locator("figure.scene").first();
  const has3d = (await scene.count()) > 0;
  if (has3d) await page.waitForSelector("figure.scene[data-ready], figure.scene.without", { timeout: 60000 });
  if (screen.flags && has3d && !(await page.locator("figure.scene.without").count())) say("no word that the 3D view cannot start");
  if (screen.grey) await page.addStyleTag({ content: "html { filter: grayscale(1); }" });
  for (const fault of await page.evaluate(faults)) say(fault);
  await page.screenshot({ path: join(out, `${screen.name}-top.png`) });
  for (const section of await page.locator("main section[id]").all()) {
    await section.screenshot({ path: join(out, `${screen.name}-${await section.getAttribute("id")}.png`) });
  }
  if (has3d && (screen.name === "desktop-light" || screen.name === "phone-dark")) await drive(page, scene, screen.name, say);
  if (screen.name === "desktop-light") {
    await page.pdf({ path: join(out, "print.pdf"), preferCSSPageSize: true, printBackground: false });
  }
  await context.close();
}
for (const complaint of complaints) console.log(complaint);
console.log(`${complaints.length} complaints`);
process.exit(complaints.length ? 1 : 0);

// Turns, cuts, recolours and runs the 3D view; each must change the picture.
async function drive(page, scene, name, say) {
  await scene.scrollIntoViewIfNeeded();
  const stage = scene.locator(".stage");
  let number = 0;
  const shoot = async (what) => {
    await page.waitForTimeout(250);
    await scene.screenshot({ path: join(out, `${name}-3d-${++number}-${what}.png`) });
    return scene.locator("canvas").last().evaluate(async (_, figure) => figure, null).then(() => picture(stage));
  };
  let before = await shoot("start");
  const expect = async (what) => {
    const after = await shoot(what);
    if (after === before) say(`3D view: ${what} changes nothing`);
    before = after;
  };
  const box = await stage.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 90, box.y + box.height / 2 - 60, { steps: 8 });
  await page.mouse.up();
  await expect("turned");
  await page.mouse.wheel(0, -300);
  await expect("nearer");
  await scene.locator("button", { hasText: "Iso" }).click();
  await expect("iso");
  const selects = scene.locator("select");
  await selects.nth(1).selectOption("x");
  await expect("section");
  await selects.nth(1).selectOption("z");
  await expect("section-z");
  await selects.nth(1).selectOption("off");
  for (const option of await selects.nth(0).locator("option").all()) {
    await selects.nth(0).selectOption(await option.getAttribute("value"));
    await expect(`colour-${(await option.textContent()).replaceAll(/\W+/g, "-")}`);
  }
  const play = scene.locator("button", { hasText: "Play" });
  await play.click();
  await page.waitForTimeout(1200);
  await scene.locator("button", { hasText: "Pause" }).click();
  await expect("running");
  await selects.nth(2).selectOption("cam");
  await expect("cam-held");
}

function picture(stage) {
  return stage.evaluate((node) => node.querySelector("canvas:not(.ramp)").toDataURL());
}

// Runs in the page: labels that overlap or leave their plot, elements wider than the screen.
function faults() {
  const found = [];
  const wide = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  if (wide > 0) found.push(`the page is ${wide} px wider than the screen`);
  for (const svg of document.querySelectorAll("svg.plot")) {
    const frame = svg.getBoundingClientRect();
    if (!frame.width) continue;
    const name = svg.getAttribute("aria-label");
    const texts = [...svg.querySelectorAll("text")].map((t) => [t.textContent, t.getBoundingClientRect()]);
    const unit = frame.width / svg.viewBox.baseVal.width;
    if (13 * unit < 9) found.push(`${name}: text is ${(13 * unit).toFixed(1)} px high`);
    texts.forEach(([text, a], i) => {
      if (a.left < frame.left - 1 || a.right > frame.right + 1 || a.top < frame.top - 1 || a.bottom > frame.bottom + 1)
        found.push(`${name}: "${text}" leaves the plot`);
      for (const [other, b] of texts.slice(i + 1)) {
        const x = Math.min(a.right, b.right) - Math.max(a.left, b.left);
        const y = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        if (x > 0.5 && y > 0.3 * Math.min(a.height, b.height)) found.push(`${name}: "${text}" and "${other}" overlap`);
      }
    });
  }
  for (const node of document.querySelectorAll(".figures dd, .figures dt, header.title dd, h1, h2, .finding p, th, button, select")) {
    if (node.scrollWidth > node.clientWidth + 1 && node.clientWidth) found.push(`"${node.textContent.slice(0, 40)}" is cut off`);
  }
  return found;
}

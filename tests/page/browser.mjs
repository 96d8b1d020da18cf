// A headless Chromium that draws in software, and a page of the sandbox in it.
import { mkdtemp, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

const QUIET = ['--headless=new', '--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
    '--disable-component-update', '--disable-sync'];
const WEBGL = ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
const WEBGPU = ['--enable-unsafe-webgpu', '--enable-features=Vulkan', '--use-vulkan=swiftshader', ...WEBGL.slice(1)];

export async function browser({ webgpu = false, ...options } = {}) {
    const folder = await mkdtemp(join(tmpdir(), 'inertia-'));
    const context = await chromium.launchPersistentContext(folder, {
        executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
        headless: true,
        args: [...QUIET, ...(webgpu ? WEBGPU : WEBGL)],
        viewport: { width: 1000, height: 640 },
        ...options,
    });
    context.setDefaultTimeout(120000);
    return { context, close: async () => { await context.close(); await rm(folder, { recursive: true, force: true }); } };
}

// A tab with the sandbox at an address, once its first frame is drawn.
export class Tab {
    constructor(tab) {
        this.tab = tab;
        this.said = [];
        this.files = [];
        tab.on('pageerror', error => this.said.push(String(error)));
        tab.on('console', line => {
            // Reading a picture back tells of how drivers do that.
            const matters = ['error', 'warning'].includes(line.type()) && !line.text().startsWith('performance warning');
            if (matters) this.said.push(line.text());
        });
        tab.on('download', file => this.files.push(file));
    }

    static async open(context, address) {
        const tab = new Tab(await context.newPage());
        await tab.go(address);
        return tab;
    }

    async go(address) {
        await this.tab.goto(address);
        await this.started();
    }

    async started() {
        await this.until(state => state.frames > 2);
    }

    state() {
        return this.tab.evaluate(() => globalThis.inertia ? JSON.parse(globalThis.inertia.page.state())
            : { frames: 0, words: document.getElementById('words').textContent });
    }

    // Waits until a state is as `holds` says.
    async until(holds, what = String(holds), seconds = 120) {
        const end = Date.now() + 1000 * seconds;
        for (;;) {
            const state = await this.state();
            if (holds(state)) return state;
            if (Date.now() > end) {
                delete state.controls;
                throw new Error(`waited in vain for ${what}: ${JSON.stringify(state)} ${this.said.join('; ')}`);
            }
            await this.tab.waitForTimeout(50);
        }
    }

    // The middle of a control of the panels, in CSS pixels.
    async control(name, role) {
        const find = state => state.controls.find(control => control.name === name && (!role || control.role === role));
        const state = await this.until(find, `a control "${name}"`);
        const scale = await this.tab.evaluate(() => devicePixelRatio);
        const [left, top, right, bottom] = find(state).rect_px.map(edge => edge / scale);
        return [(left + right) / 2, (top + bottom) / 2];
    }

    async click(name, role) {
        await this.tab.mouse.click(...await this.control(name, role), { delay: 60 });
    }

    async tap(name, role) {
        await this.tab.touchscreen.tap(...await this.control(name, role));
    }

    async drag([x, y], [right, down], steps = 12) {
        const { mouse } = this.tab;
        await mouse.move(x, y);
        await mouse.down();
        for (let i = 1; i <= steps; i += 1) {
            await mouse.move(x + right * i / steps, y + down * i / steps);
            await this.tab.waitForTimeout(50);
        }
        await mouse.up();
    }
}

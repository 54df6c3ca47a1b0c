"""What a screen sends into the eye, measured in a picture of it."""

import base64

from playwright.sync_api import Page

MEASURE = """async coded => {
  const bytes = Uint8Array.from(atob(coded), letter => letter.charCodeAt(0));
  const picture = await createImageBitmap(new Blob([bytes]));
  const canvas = new OffscreenCanvas(picture.width, picture.height);
  const context = canvas.getContext("2d");
  context.drawImage(picture, 0, 0);
  const {data} = context.getImageData(0, 0, picture.width, picture.height);
  const linear = Float64Array.from({length: 256}, (_, value) =>
    value <= 10 ? value / 255 / 12.92 : ((value / 255 + 0.055) / 1.055) ** 2.4);
  let luminance = 0, blue = 0;
  for (let at = 0; at < data.length; at += 4) {
    const [r, g, b] = [linear[data[at]], linear[data[at + 1]], linear[data[at + 2]]];
    luminance = Math.max(luminance, 0.2126 * r + 0.7152 * g + 0.0722 * b);
    blue = Math.max(blue, b);
  }
  return [luminance, blue];
}"""


def brightest(page: Page) -> tuple[float, float]:
    """The luminance of the brightest point, 1 is white; and the most blue that any point sends (linear, 0..1)."""
    luminance, blue = page.evaluate(MEASURE, base64.b64encode(page.screenshot()).decode())
    return float(luminance), float(blue)

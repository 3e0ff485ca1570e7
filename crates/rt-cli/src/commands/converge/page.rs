//! HTML page of an experiment, self-contained.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use rt_image::metrics::{ColourScale, ErrorMap, heat_map};
use rt_image::{Development, Image, ImageFormat, write_image};

use super::report::Report;
use super::table::{self, TextTable};

/// Quantile of the errors at the end of the color scale.
const SHOWN_ERRORS: f64 = 0.999;

const STYLE: &str = "
  body { font: 15px/1.45 sans-serif; margin: 2em auto; max-width: 1150px; padding: 0 1em; color: #222; }
  svg { width: 100%; height: auto; }
  table { border-collapse: collapse; margin: 1em 0; font-variant-numeric: tabular-nums; }
  td, th { border-bottom: 1px solid #ddd; padding: .2em .7em; text-align: right; white-space: nowrap; }
  td:first-child, th:first-child { text-align: left; }
  .wide { overflow-x: auto; }
  .images { display: flex; flex-wrap: wrap; gap: 1.2em; }
  figure { margin: 0; }
  figcaption { font-size: 13px; }
  figure img { image-rendering: pixelated; min-width: 256px; max-width: 100%; display: block; }
  #slider { position: relative; display: inline-block; max-width: 100%; line-height: 0; }
  #slider img { image-rendering: pixelated; min-width: min(640px, 90vw); max-width: 100%; }
  #slider .after { position: absolute; inset: 0; clip-path: inset(0 0 0 50%); }
  #slider .bar { position: absolute; top: 0; bottom: 0; left: 50%; width: 2px; margin-left: -1px; background: #fff; outline: 1px solid #000; }
  #slider input { position: absolute; inset: 0; width: 100%; height: 100%; margin: 0; opacity: 0; cursor: ew-resize; }
  .scale { display: inline-block; width: 220px; height: 12px; vertical-align: middle; }
";

/// Script of the before-and-after slider.
const SCRIPT: &str = "
  const images = [...document.querySelectorAll('img.shown')];
  const [before, after] = ['before', 'after'].map(id => document.getElementById(id));
  const [under, over] = ['.before', '.after'].map(name => document.querySelector('#slider ' + name));
  const range = document.querySelector('#slider input'), bar = document.querySelector('#slider .bar');
  for (const select of [before, after])
    images.forEach((image, index) => select.add(new Option(image.alt, index)));
  const show = () => {
    under.src = images[before.value].src;
    over.src = images[after.value].src;
    over.style.clipPath = `inset(0 0 0 ${range.value}%)`;
    bar.style.left = `${range.value}%`;
  };
  before.value = 0;
  after.value = images.length - 1;
  for (const input of [before, after, range]) input.addEventListener('input', show);
  show();
";

impl Report<'_> {
    /// The page, with the plot as SVG if there is one.
    pub(super) fn html(&self, plot: Option<&str>) -> Result<String, String> {
        let mut page = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{0}</title>\n<style>{STYLE}</style>\n<h1>{0}</h1>\n",
            escape(&self.title())
        );
        // Inline SVG needs no name space.
        let plot = plot.unwrap_or("<p>No measurement is above the error of the reference.</p>");
        page.push_str(&plot.replace(" xmlns=\"http://www.w3.org/2000/svg\"", ""));
        page.push_str(&html_table(&table::methods(&self.summary)));
        page.push_str(&html_table(&table::points(&self.summary, self.reference.image().is_some())));
        for note in self.notes() {
            page.push_str(&format!("<p>{}</p>\n", escape(&note)));
        }
        page.push_str(&self.slider());
        page.push_str(&self.images()?);
        page.push_str(&self.error_maps()?);
        page.push_str(&format!("<h2>Measured on</h2>\n<p>{}</p>\n", escape(&self.info.machine.line())));
        page.push_str(&format!("<script>{SCRIPT}</script>\n</html>\n"));
        Ok(page)
    }

    /// Two images over each other, filled by the script.
    fn slider(&self) -> String {
        "<h2>Before and after</h2>\n<p><select id=\"before\"></select> left, <select id=\"after\"></select> right of the bar; \
         drag it</p>\n<div id=\"slider\"><img class=\"before\" alt=\"left\"><img class=\"after\" alt=\"right\">\
         <div class=\"bar\"></div><input type=\"range\" min=\"0\" max=\"100\" value=\"50\" step=\"0.1\" \
         aria-label=\"position of the bar\"></div>\n"
            .to_owned()
    }

    /// All images, the reference last.
    fn images(&self) -> Result<String, String> {
        let mut figures = String::new();
        for measured in &self.experiment.methods {
            for image in measured.images.iter().flatten() {
                let caption = format!("{}, {} spp", measured.name.label, image.spp);
                figures.push_str(&figure(&image.film, &self.development, &caption, "shown")?);
            }
        }
        if let Some(reference) = self.reference.image() {
            let development = reference.development(&self.development);
            figures.push_str(&figure(&reference.film, &development, "reference", "shown")?);
        }
        Ok(format!(
            "<h2>Images</h2>\n<p>Fewest and most samples, first seed.</p>\n<div class=\"images\">\n{figures}</div>\n"
        ))
    }

    /// Heat maps of all methods with the most samples, on one scale.
    fn error_maps(&self) -> Result<String, String> {
        let Some(reference) = self.reference.image() else {
            let text = "<p>The truth is the mean over the image; errors of single pixels are unknown.</p>";
            return Ok(format!("<h2>Errors</h2>\n{text}\n"));
        };
        let images = self.experiment.methods.iter().filter_map(|method| Some((method, method.last_image()?)));
        let maps = images.map(|(method, image)| {
            let map = reference.error_map(&image.film).map_err(|error| error.to_string())?;
            Ok((format!("{}, {} spp", method.name.label, image.spp), map))
        });
        let maps: Vec<(String, ErrorMap)> = maps.collect::<Result<_, String>>()?;
        let limit = maps.iter().map(|(_, map)| map.magnitude_quantile(SHOWN_ERRORS)).fold(0.0, f64::max);
        let mut figures = String::new();
        for (caption, map) in &maps {
            let film = heat_map(map, ColourScale::Signed, limit);
            figures.push_str(&figure(&film, &Development::default(), caption, "error")?);
        }
        Ok(format!("<h2>Errors</h2>\n{}<div class=\"images\">\n{figures}</div>\n", legend(limit)))
    }
}

/// Color scale.
fn legend(limit: f64) -> String {
    let stops = (-4..=4).map(|step| {
        let [r, g, b] = ColourScale::Signed.colour(f64::from(step), 4.0);
        format!("rgb({r},{g},{b})")
    });
    let stops = stops.collect::<Vec<_>>().join(", ");
    let limit = table::number(limit);
    format!(
        "<p>Signed error of the channel that differs most, first seed, on the same scale for all: −{limit} or less \
         <span class=\"scale\" style=\"background: linear-gradient(to right, {stops})\"></span> {limit} or more</p>\n"
    )
}

fn figure(film: &Image, development: &Development, caption: &str, class: &str) -> Result<String, String> {
    let mut png = Vec::new();
    write_image(film, development, ImageFormat::Png, &mut png).map_err(|error| error.to_string())?;
    let caption = escape(caption);
    let data = BASE64_STANDARD.encode(png);
    Ok(format!(
        "<figure><img class=\"{class}\" alt=\"{caption}\" src=\"data:image/png;base64,{data}\">\
         <figcaption>{caption}</figcaption></figure>\n"
    ))
}

fn html_table(table: &TextTable) -> String {
    let row = |cells: &[&str], tag: &str| {
        let cells: String = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escape(cell))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let text = |cells: &Vec<String>| row(&cells.iter().map(String::as_str).collect::<Vec<_>>(), "td");
    let rows: String = table.rows.iter().map(text).collect();
    format!("<div class=\"wide\"><table>\n{}{rows}</table></div>\n", row(&table.header, "th"))
}

/// Text as HTML shows it literally.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        let sheet = html_table(&TextTable { header: vec!["a<b"], rows: vec![vec!["\"x\" & y".to_owned()]] });
        assert!(sheet.contains("<th>a&lt;b</th>") && sheet.contains("<td>&quot;x&quot; &amp; y</td>"), "{sheet}");
    }

    #[test]
    fn images_are_part_of_the_page() {
        let text = figure(&Image::new(2, 2, false), &Development::default(), "a > b", "shown").expect("a PNG");
        assert!(text.contains("alt=\"a &gt; b\" src=\"data:image/png;base64,iVBORw0KGgo"), "{text}");
    }
}

//! Plot of log RMSE against log seconds, one line per method, as SVG and as pixels.
//!
//! The font DejaVu Sans is compiled in, so that the plot does not depend on the fonts of the system.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use rt_image::{Bitmap8, Encoding, Image};

use super::log_axis::{LogAxis, exponent};
use super::reference::Floor;
use super::summary::{PointSummary, Summary};

/// Width and height in pixels.
const SIZE: (u32, u32) = (1100, 720);

const FONT: &str = "DejaVu Sans";

/// Palette for all kinds of color vision (Okabe and Ito 2008), without yellow, which has little contrast on white.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];

const GUIDE: RGBColor = RGBColor(150, 150, 150);
const GUIDE_TEXT: RGBColor = RGBColor(110, 110, 110);
const FLOOR: RGBColor = RGBColor(180, 0, 0);

#[derive(Debug)]
pub(super) struct Plot {
    title: String,
    lines: Vec<Line>,
    /// Exponent of ten of the RMSE of the reference.
    floor: Option<f64>,
    seconds: LogAxis,
    errors: LogAxis,
}

#[derive(Debug)]
struct Line {
    label: String,
    marks: Vec<PlotPoint>,
}

/// Measurement at one sample count, as exponents of ten.
#[derive(Clone, Copy, Debug)]
struct PlotPoint {
    seconds: f64,
    low: f64,
    mean: f64,
    high: f64,
}

impl Plot {
    /// Plot of all trusted points; `None` if there are none.
    pub(super) fn new(title: String, summary: &Summary, floor: Option<Floor>) -> Option<Self> {
        let lines = summary.methods.iter().map(|method| {
            let trusted = method.points.iter().filter(|point| point.is_trusted && point.seconds > 0.0);
            let mark = |point: &PointSummary| {
                let interval = point.rmse_interval?.map(exponent);
                Some(PlotPoint {
                    seconds: exponent(point.seconds),
                    low: interval.low,
                    mean: interval.mean,
                    high: interval.high,
                })
            };
            Line { label: method.name.label.clone(), marks: trusted.filter_map(mark).collect() }
        });
        let lines: Vec<Line> = lines.collect();
        let marks = || lines.iter().flat_map(|line| &line.marks);
        let floor = floor.map(|floor| exponent(floor.mse.sqrt())).filter(|floor| floor.is_finite());
        let seconds = LogAxis::around(marks().map(|mark| mark.seconds), 0.1)?;
        // Clip wide intervals, which would flatten all lines.
        let ends = |mark: &PlotPoint| [mark.mean, mark.low.max(mark.mean - 1.0), mark.high.min(mark.mean + 1.0)];
        let errors = LogAxis::around(marks().flat_map(ends).chain(floor), 0.15)?;
        Some(Self { title, lines, floor, seconds, errors })
    }

    pub(super) fn svg(&self) -> Result<String, String> {
        let mut text = String::new();
        self.draw(SVGBackend::with_string(&mut text, SIZE).into_drawing_area())?;
        Ok(text)
    }

    /// Plot as an image for the default tone mapping.
    pub(super) fn film(&self) -> Result<Image, String> {
        let (width, height) = SIZE;
        let mut bytes = vec![255; width as usize * height as usize * 3];
        self.draw(BitMapBackend::with_buffer(&mut bytes, SIZE).into_drawing_area())?;
        Ok(Bitmap8 { width, height, channels: 3, bytes }.decode(Encoding::Srgb))
    }

    fn draw<B: DrawingBackend>(&self, area: DrawingArea<B, Shift>) -> Result<(), String> {
        register_font(FONT, FontStyle::Normal, dejavu::sans::regular()).map_err(|_| "the font is damaged")?;
        self.draw_on(&area).map_err(|error| error.to_string())
    }

    fn draw_on<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        area.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, (FONT, 22))
            .margin(16)
            .x_label_area_size(52)
            .y_label_area_size(84)
            .build_cartesian_2d(self.seconds, self.errors)?;
        chart
            .configure_mesh()
            .x_desc("processor seconds of rendering")
            .y_desc("RMSE (mean of its logarithm over the seeds, 95 % interval)")
            .label_style((FONT, 14))
            .axis_desc_style((FONT, 15))
            .light_line_style(RGBColor(240, 240, 240))
            .bold_line_style(RGBColor(215, 215, 215))
            .draw()?;
        for (slope, name) in [(-0.5, "slope −1/2"), (-1.0, "slope −1")] {
            let guide = self.guide(slope);
            chart.draw_series(DashedLineSeries::new(guide, 6, 5, GUIDE.stroke_width(1)))?;
            // Below the line, which comes from the upper left.
            let style = TextStyle::from((FONT, 13)).color(&GUIDE_TEXT).pos(Pos::new(HPos::Right, VPos::Top));
            chart.draw_series([EmptyElement::at(guide[1]) + Text::new(name, (-2, 6), style)])?;
        }
        if let Some(floor) = self.floor {
            let line = [self.seconds.low, self.seconds.high].map(|seconds| (seconds, floor));
            let line = DashedLineSeries::new(line, 2, 4, FLOOR.stroke_width(2));
            let legend = |(x, y)| PathElement::new([(x, y), (x + 22, y)], FLOOR.stroke_width(2));
            chart.draw_series(line)?.label("error of the reference").legend(legend);
        }
        for (index, line) in self.lines.iter().enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            let bar = |mark: &PlotPoint| {
                let [low, high] = [mark.low, mark.high].map(|end| end.clamp(self.errors.low, self.errors.high));
                PathElement::new([(mark.seconds, low), (mark.seconds, high)], colour)
            };
            chart.draw_series(line.marks.iter().map(bar))?;
            let dot = |mark: &PlotPoint| Circle::new((mark.seconds, mark.mean), 4, colour.filled());
            chart.draw_series(line.marks.iter().map(dot))?;
            let path = line.marks.iter().map(|mark| (mark.seconds, mark.mean));
            // Lines of a repeated color have different dashes.
            let series = match i32::try_from(index / COLOURS.len()).unwrap_or(i32::MAX) {
                0 => chart.draw_series(LineSeries::new(path, colour.stroke_width(2)))?,
                turn => chart.draw_series(DashedLineSeries::new(path, 16 / turn, 6, colour.stroke_width(2)))?,
            };
            let legend = move |(x, y)| PathElement::new([(x, y), (x + 22, y)], colour.stroke_width(3));
            series.label(&line.label).legend(legend);
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.85))
            .border_style(GUIDE)
            .label_font((FONT, 14))
            .draw()?;
        area.present()
    }

    /// End points of a line of this slope through the upper left corner.
    fn guide(&self, slope: f64) -> [(f64, f64); 2] {
        let (left, top) = (self.seconds.low, self.errors.high);
        let right = (left + (self.errors.low - top) / slope).min(self.seconds.high);
        [(left, top), (right, top + slope * (right - left))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(methods: usize) -> Plot {
        let mark = |at: f64| PlotPoint { seconds: at, low: -at - 0.2, mean: -at, high: -at + 0.1 };
        let line = |index| Line { label: format!("<{index}>"), marks: [0.0, 0.5, 1.0].map(mark).to_vec() };
        Plot {
            title: "title".to_owned(),
            lines: (0..methods).map(line).collect(),
            floor: Some(-2.0),
            seconds: LogAxis { low: -0.1, high: 1.1 },
            errors: LogAxis { low: -2.1, high: 0.2 },
        }
    }

    #[test]
    fn lines_run_across_the_plot() {
        let film = plot(1).film().expect("drawn");
        let blue = [0, 114, 178].map(|byte| Encoding::Srgb.decode(byte));
        let columns = (0..SIZE.0).filter(|&x| {
            // Below the legend.
            (200..SIZE.1).any(|y| film.pixels()[(y * SIZE.0 + x) as usize] == blue)
        });
        // Five sixths of the width between the labels at the axis and the margin, but for what is above.
        let columns = columns.count();
        assert!(columns > 500, "{columns}");
    }

    #[test]
    fn both_forms_show_the_same_and_text_is_escaped() {
        let svg = plot(9).svg().expect("drawn");
        for part in ["&lt;8&gt;", "slope −1/2", "slope −1", "error of the reference", "#0072B2", "title"] {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg.matches("<circle").count(), 9 * 3);
    }
}

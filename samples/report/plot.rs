//! The plots, as SVG.

use plotters::{
    chart::ChartContext,
    coord::{
        Shift,
        cartesian::Cartesian2d,
        combinators::{BindKeyPoints, IntoLogRange},
        ranged1d::{AsRangedCoord, Ranged, ValueFormatter},
    },
    element::DashedPathElement,
    prelude::*,
};
use prism_engine::error::{Error, Result};

use super::{
    fit,
    measure::Point,
    variants::{Family, Variant},
};

/// Of the whole picture, in its own units.
const SIZE: (u32, u32) = (760, 520);
/// For the names of the curves.
const LEGEND: u32 = 220;
/// Height of a name; less where there are many.
const ROW: i32 = 20;
/// Errors below this are drawn at it: the least decade of the axis.
pub const LEAST_ERROR: f64 = 1e-5;
/// The same of FLIP, which a picture in 8 bits cannot tell from none.
const LEAST_FLIP: f64 = 1e-4;
const FONT: &str = "sans-serif";
const INK: RGBColor = RGBColor(32, 36, 42);
const GRID: RGBColor = RGBColor(226, 229, 233);
const FINE_GRID: RGBColor = RGBColor(244, 245, 247);

/// A line through places, with a name.
struct Curve {
    name: String,
    colour: RGBColor,
    marker: usize,
    /// Thicker than the others.
    strong: bool,
    places: Vec<Place>,
}

/// A place, how far its x or y spreads, and what lies outside of that.
struct Place {
    at: [f64; 2],
    quartiles: [[f64; 2]; 2],
    outliers: Vec<[f64; 2]>,
}

impl Place {
    /// Its x (0) or y (1), and how far that spreads.
    fn reach(&self, k: usize) -> [f64; 3] {
        [self.at[k], self.quartiles[0][k], self.quartiles[1][k]]
    }
}

/// Axes of a plot.
struct Axes<'a> {
    x: &'a str,
    y: &'a str,
    /// Steps through these places, dashed.
    front: Vec<[f64; 2]>,
    /// Where x has a label, if it is logarithmic.
    ticks: Vec<f64>,
}

fn failed(cause: impl std::fmt::Display) -> Error {
    Error::input("plot", "SVG", format!("cannot be drawn: {cause}"), "report this as a bug")
}

/// The error of a front.
#[derive(Clone, Copy)]
pub enum Judged {
    /// 99th percentile of the depth error.
    Depth,
    /// Mean FLIP of the picture.
    Flip,
}

/// Error against time: a curve a technique, and the front of all points.
pub fn front(points: &[&Point], judged: Judged) -> Result<String> {
    let place = |point: &Point| {
        let [ms, depth] = point.place();
        let error = match judged {
            Judged::Depth => depth.max(LEAST_ERROR),
            Judged::Flip => point.flip?.max(LEAST_FLIP),
        };
        Some([ms, error])
    };
    let curves = curves(points, |point| {
        let [ms, error] = place(point)?;
        let spread = point.timing.spread();
        let [low, high] = spread.map_or([ms; 2], |spread| [spread.low, spread.high]);
        let outliers = point.timing.outliers().into_iter().map(|ms| [ms, error]).collect();
        Some(Place { at: [ms, error], quartiles: [[low, error], [high, error]], outliers })
    });
    let places: Vec<[f64; 2]> = points.iter().filter_map(|point| place(point)).collect();
    let front = fit::pareto(&places).into_iter().map(|i| places[i]).collect();
    let y = match judged {
        Judged::Depth => "depth error, 99th percentile (pixel footprints)",
        Judged::Flip => "mean FLIP of the picture",
    };
    let times = near(curves.iter().flat_map(|curve| &curve.places).flat_map(|place| place.reach(0)));
    let ticks = round_numbers(&times);
    plot(&Axes { x: "GPU time of a frame (ms)", y, front, ticks }, &curves, true)
}

/// Something against what a part varies: a curve a technique.
pub fn sweep(points: &[&Point], x: &str, y: &str, value: impl Fn(&Point) -> f64, timed: bool) -> Result<String> {
    let curves = curves(points, |point| {
        let (x, y) = (point.x?, value(point));
        let spread = point.timing.spread().filter(|_| timed);
        let [low, high] = spread.map_or([y; 2], |spread| [spread.low, spread.high]);
        let outliers = if timed { point.timing.outliers() } else { Vec::new() };
        let outliers = outliers.into_iter().map(|ms| [x, ms]).collect();
        Some(Place { at: [x, y], quartiles: [[x, low], [x, high]], outliers })
    });
    // Where it starts at nothing a logarithm has no place for it.
    let logarithmic = points.iter().filter_map(|point| point.x).all(|x| x > 0.0);
    // What was measured, and no other.
    let mut ticks: Vec<f64> = points.iter().filter_map(|point| point.x).collect();
    ticks.sort_by(f64::total_cmp);
    ticks.dedup();
    plot(&Axes { x, y, front: Vec::new(), ticks }, &curves, logarithmic)
}

fn curves(points: &[&Point], place: impl Fn(&Point) -> Option<Place>) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    let mut of_family = [0usize; 4];
    for point in points {
        let Some(place) = place(point).filter(|place| place.at.iter().all(|v| v.is_finite())) else { continue };
        let name = &point.variant.technique;
        if let Some(curve) = curves.iter_mut().find(|curve| curve.name == *name) {
            curve.places.push(place);
            continue;
        }
        let nth = &mut of_family[point.variant.family as usize];
        let strong = point.variant.is_walk_exact();
        let (colour, marker) = (colour(&point.variant, *nth), *nth);
        *nth += 1;
        curves.push(Curve { name: name.clone(), colour, marker, strong, places: vec![place] });
    }
    curves
}

/// Warm on the base surface, green in prisms, blue in the walk, violet and red for what it is compared with; ours exact
/// the darkest.
fn colour(variant: &Variant, nth: usize) -> RGBColor {
    let hue = match variant.family {
        Family::Base => 0.03 + 0.012 * nth as f64,
        Family::Prism => 0.34 + 0.012 * nth as f64,
        Family::Walk => 0.55 + 0.012 * nth as f64,
        Family::Baseline => 0.80 + 0.05 * nth as f64,
    };
    let lightness = if variant.is_walk_exact() { 0.25 } else { [0.44, 0.60, 0.36, 0.68][nth % 4] };
    let (r, g, b) = HSLColor(hue.fract(), 0.8, lightness).to_backend_color().rgb;
    RGBColor(r, g, b)
}

/// The powers of ten that hold all values.
fn decades(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) =
        values.filter(|v| *v > 0.0 && v.is_finite()).fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return 0.1..1.0;
    }
    let (low, high) = ((low.log10() - 0.05).floor(), (high.log10() + 0.05).ceil());
    10f64.powf(low)..10f64.powf(high.max(low + 1.0))
}

/// A logarithmic axis that ends near its values.
fn near(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) =
        values.filter(|v| *v > 0.0 && v.is_finite()).fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    if low > high { 0.1..1.0 } else { low / 1.4..high * 1.4 }
}

/// All digits.
const DIGITS: &[f64] = &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];

/// Labels of a logarithmic axis: powers of ten, and the fewer of them there are, the more of their multiples.
fn round_numbers(range: &std::ops::Range<f64>) -> Vec<f64> {
    let steps = match range.end / range.start {
        wide if wide > 300.0 => &DIGITS[..1],
        some if some > 8.0 => &[1.0, 2.0, 5.0],
        _ => DIGITS,
    };
    multiples(range, steps)
}

/// So many times each power of ten, within a range.
fn multiples(range: &std::ops::Range<f64>, steps: &[f64]) -> Vec<f64> {
    let [first, last] = [range.start, range.end].map(|v| v.log10().floor() as i32);
    let all = (first..=last).flat_map(|power| steps.iter().map(move |step| step * 10f64.powi(power)));
    // Its ends are in it, however they are rounded.
    all.filter(|value| (0.999 * range.start..=1.001 * range.end).contains(value)).collect()
}

fn plot(axes: &Axes<'_>, curves: &[Curve], logarithmic: bool) -> Result<String> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        let (left, right) = root.split_horizontally(SIZE.0 - LEGEND);
        let all = || curves.iter().flat_map(|curve| &curve.places);
        let reach = |k: usize| all().flat_map(move |p| p.reach(k));
        let y = decades(reach(1));
        let (bold, fine) = (round_numbers(&y), multiples(&y, DIGITS));
        let y = y.log_scale().with_key_points(bold).with_light_points(fine);
        if logarithmic {
            let x = near(reach(0));
            let fine = multiples(&x, DIGITS);
            let x = x.log_scale().with_key_points(axes.ticks.clone()).with_light_points(fine);
            chart(&left, axes, curves, x, y)?;
        } else {
            let most = reach(0).fold(0.0, f64::max);
            chart(&left, axes, curves, -0.02 * most..1.04 * most, y)?;
        }
        legend(&right, axes, curves)?;
        root.present().map_err(failed)?;
    }
    Ok(svg)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn chart<X, Y>(area: &Area<'_>, axes: &Axes<'_>, curves: &[Curve], x: X, y: Y) -> Result<()>
where
    X: AsRangedCoord<Value = f64>,
    X::CoordDescType: ValueFormatter<f64>,
    Y: AsRangedCoord<Value = f64>,
    Y::CoordDescType: ValueFormatter<f64>,
{
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .set_label_area_size(LabelAreaPosition::Left, 66)
        .set_label_area_size(LabelAreaPosition::Bottom, 52)
        .build_cartesian_2d(x, y)
        .map_err(failed)?;
    chart
        .configure_mesh()
        .x_desc(axes.x)
        .y_desc(axes.y)
        .axis_desc_style((FONT, 18).into_font().color(&INK))
        .label_style((FONT, 15).into_font().color(&INK))
        .axis_style(INK)
        .bold_line_style(GRID)
        .light_line_style(FINE_GRID)
        .x_label_formatter(&|x| tick(*x))
        .y_label_formatter(&|y| tick(*y))
        .draw()
        .map_err(failed)?;
    // What all are compared with, over the others.
    for strong in [false, true] {
        for curve in curves.iter().filter(|curve| curve.strong == strong) {
            draw_curve(&mut chart, curve)?;
        }
    }
    let mut steps: Vec<(f64, f64)> = Vec::new();
    for [x, y] in &axes.front {
        // Until the next point is reached, nothing better is to be had than the last one.
        if let Some((_, last)) = steps.last().copied() {
            steps.push((*x, last));
        }
        steps.push((*x, *y));
    }
    if !steps.is_empty() {
        chart.draw_series(std::iter::once(DashedPathElement::new(steps, 6, 4, INK.stroke_width(2)))).map_err(failed)?;
    }
    Ok(())
}

fn draw_curve<'a, X, Y>(chart: &mut ChartContext<'a, SVGBackend<'_>, Cartesian2d<X, Y>>, curve: &Curve) -> Result<()>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    let pair = |[x, y]: [f64; 2]| (x, y);
    let line = curve.colour.stroke_width(if curve.strong { 3 } else { 1 });
    chart.draw_series(LineSeries::new(curve.places.iter().map(|p| pair(p.at)), line)).map_err(failed)?;
    for place in &curve.places {
        let quartiles = place.quartiles.map(pair).to_vec();
        let faint = curve.colour.mix(0.5).stroke_width(1);
        chart.draw_series([PathElement::new(quartiles, faint)]).map_err(failed)?;
        let crosses = place.outliers.iter().map(|at| Cross::new(pair(*at), 2, GREY));
        chart.draw_series(crosses).map_err(failed)?;
        let shape = EmptyElement::at(pair(place.at)) + marker(curve);
        chart.draw_series([shape]).map_err(failed)?;
    }
    Ok(())
}

const GREY: RGBColor = RGBColor(150, 150, 150);

/// A small shape around its place, by which curves of like colours are told apart.
fn marker(curve: &Curve) -> Polygon<(i32, i32)> {
    let corners: &[(i32, i32)] = match curve.marker % 6 {
        0 => &[(-4, -2), (-2, -4), (2, -4), (4, -2), (4, 2), (2, 4), (-2, 4), (-4, 2)],
        1 => &[(0, -5), (5, 4), (-5, 4)],
        2 => &[(-4, -4), (4, -4), (4, 4), (-4, 4)],
        3 => &[(0, -5), (5, 0), (0, 5), (-5, 0)],
        4 => &[(0, 5), (5, -4), (-5, -4)],
        _ => &[
            (-5, -2),
            (-2, -2),
            (-2, -5),
            (2, -5),
            (2, -2),
            (5, -2),
            (5, 2),
            (2, 2),
            (2, 5),
            (-2, 5),
            (-2, 2),
            (-5, 2),
        ],
    };
    Polygon::new(corners, curve.colour.filled())
}

fn tick(value: f64) -> String {
    if value == 0.0 || (0.01..10_000.0).contains(&value.abs()) {
        format!("{}", (value * 1000.0).round() / 1000.0)
    } else {
        let power = (value.abs().log10() + 0.01).floor();
        format!("{}e{power}", (value / 10f64.powf(power) * 10.0).round() / 10.0)
    }
}

fn legend(area: &Area<'_>, axes: &Axes<'_>, curves: &[Curve]) -> Result<()> {
    let style = TextStyle::from((FONT, 15).into_font()).color(&INK);
    let row = ROW.min((SIZE.1 as i32 - 40) / (curves.len() as i32 + 1));
    let mut top = 20;
    for curve in curves {
        let line = vec![(6, top + 7), (34, top + 7)];
        area.draw(&PathElement::new(line, curve.colour.stroke_width(if curve.strong { 3 } else { 1 })))
            .map_err(failed)?;
        area.draw(&(EmptyElement::at((20, top + 7)) + marker(curve))).map_err(failed)?;
        area.draw(&Text::new(curve.name.clone(), (42, top), style.clone())).map_err(failed)?;
        top += row;
    }
    if !axes.front.is_empty() {
        let line = vec![(6, top + 7), (34, top + 7)];
        area.draw(&DashedPathElement::new(line, 6, 4, INK.stroke_width(2))).map_err(failed)?;
        area.draw(&Text::new("Pareto front", (42, top), style)).map_err(failed)?;
    }
    Ok(())
}

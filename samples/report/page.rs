//! The page: one HTML file that needs nothing else.

use std::{fmt::Write as _, time::SystemTime};

use base64::{Engine as _, engine::general_purpose::STANDARD};
use prism_engine::error::{Error, Result};

use super::{
    contest::Aim,
    fit,
    measure::{Measured, Point, Shown},
    parts::{self, Part},
    plot,
    table::{FOR_PEOPLE, short},
};
use crate::{
    app::{cli::ReportArgs, picture::Picture, png},
    timing::Device,
};

/// What was measured on, when and how.
pub struct About {
    device: String,
    on_cpu: bool,
    size: [u32; 2],
    rounds: u32,
    minutes: u64,
    quick: bool,
    started: String,
    seconds: u64,
}

impl About {
    /// Of a run that ends now.
    pub fn new(device: &Device, args: &ReportArgs, started: SystemTime) -> About {
        About {
            device: format!("{}, {}", device.ctx.device_name(), device.ctx.driver().trim()),
            on_cpu: device.ctx.is_cpu(),
            size: args.pixels(),
            rounds: args.rounds(),
            minutes: args.budget().as_secs() / 60,
            quick: args.quick,
            started: humantime::format_rfc3339_seconds(started).to_string(),
            seconds: started.elapsed().map_or(0, |elapsed| elapsed.as_secs()),
        }
    }

    fn line(&self) -> String {
        let [width, height] = self.size;
        format!(
            "{}; {width}×{height} pixels; up to {} rounds, as many as {} min let; {}begun {}, took {} s",
            self.device,
            self.rounds,
            self.minutes,
            if self.quick { QUICK } else { "" },
            self.started,
            self.seconds
        )
    }
}

/// What sets a quick run apart.
const QUICK: &str = "--quick: a look, no figure worth quoting, timed while surface data are written; ";

/// A part as it is shown.
pub struct Section {
    title: String,
    text: &'static str,
    /// File name without ending, and SVG.
    pub plots: Vec<(String, String)>,
    /// Sentences under the plots.
    findings: Vec<String>,
    /// Who is faster within one error, and where that changes.
    duel: Vec<String>,
    points: Vec<Point>,
    /// The stand of the points is told in a column.
    varies: Option<&'static str>,
    shown: Vec<Embedded>,
}

/// Pictures with their words.
struct Embedded {
    name: String,
    figures: String,
    /// What it is, and the picture as a data address.
    pictures: Vec<(&'static str, String)>,
}

impl Section {
    /// Draws a part's plots.
    pub fn of(part: &Part, measured: &Measured) -> Result<Section> {
        let points: Vec<&Point> = measured.points.iter().collect();
        let mut plots = Vec::new();
        let (mut findings, mut duel) = (Vec::new(), Vec::new());
        if let Some(varies) = part.varies {
            let ms = |point: &Point| point.place()[0];
            plots.push((
                format!("{}-time", part.id),
                plot::sweep(&points, varies, "GPU time of a frame (ms)", ms, true)?,
            ));
            let error = |point: &Point| point.metrics.depth_p99.max(plot::LEAST_ERROR);
            let label = "depth error, 99th percentile (footprints)";
            plots.push((format!("{}-error", part.id), plot::sweep(&points, varies, label, error, false)?));
            findings = growth(&points, varies);
            let fastest = within_one_error(&points);
            if !fastest.is_empty() {
                let fastest: Vec<&Point> = fastest.iter().collect();
                plots.push((
                    format!("{}-crossover", part.id),
                    plot::sweep(&fastest, varies, "GPU time at equal error (ms)", ms, true)?,
                ));
                duel = at_equal_error(&fastest, varies);
            }
        } else {
            let file =
                if part.id == "front" { format!("front-{}", word(&part.stands[0].scene)) } else { part.id.to_owned() };
            let flip = format!("{file}-flip");
            plots.push((file, plot::front(&points, plot::Judged::Depth)?));
            findings.extend(on_front(&points));
            if points.iter().any(|point| point.flip.is_some()) {
                plots.push((flip, plot::front(&points, plot::Judged::Flip)?));
            }
        }
        let timed: Vec<usize> = points.iter().map(|point| point.timing.times.len()).collect();
        let least = timed.iter().copied().min().unwrap_or(0);
        let plural = if least == 1 { "" } else { "s" };
        let seconds = measured.took.as_secs();
        findings.push(format!("{} points, {least} round{plural} in turns, {seconds} s in all.", timed.len()));
        if !measured.left_out.is_empty() {
            findings.push(format!("This device lacks the stages for: {}.", measured.left_out.join(", ")));
        }
        let shown = measured.shown.iter().map(embedded).collect::<Result<_>>()?;
        let points = measured.points.clone();
        let title = part.title.clone();
        Ok(Section { title, text: part.text, plots, findings, duel, points, varies: part.varies, shown })
    }
}

/// One sentence on what lies on the front of a part without a sweep, from fast to exact; none where that is all.
fn on_front(points: &[&Point]) -> Option<String> {
    let front = fit::pareto(&points.iter().map(|point| point.place()).collect::<Vec<_>>());
    let told = |i: &usize| {
        let [ms, error] = points[*i].place();
        format!("{} ({} ms, {})", points[*i].variant.name(), short(ms), short(error))
    };
    let told: Vec<String> = front.iter().map(told).collect();
    (told.len() < points.len()).then(|| format!("On the front, with time and p99: {}.", told.join("; ")))
}

/// A scene's name without what a file name cannot have.
fn word(scene: &str) -> String {
    let stem = std::path::Path::new(scene).file_stem().map_or(scene.into(), |stem| stem.to_string_lossy());
    stem.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect()
}

/// One sentence a technique on how its time grows: as a power of what is varied, or where that begins at nothing, from
/// its first value to its last.
fn growth(points: &[&Point], varies: &str) -> Vec<String> {
    let mut names: Vec<&str> = Vec::new();
    for point in points {
        let name = point.variant.technique.as_str();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let curve = |name: &str, y: fn(&Point) -> f64| -> Vec<[f64; 2]> {
        let own = points.iter().filter(|point| point.variant.technique == name);
        own.filter_map(|point| Some([point.x?, y(point)])).collect()
    };
    let ms = |point: &Point| point.place()[0];
    let logarithmic = points.iter().filter_map(|point| point.x).all(|x| x > 0.0);
    let grown = |name: &&str| {
        let of = |y: fn(&Point) -> f64| {
            let curve = curve(name, y);
            Some((curve.first().map(|[_, y]| short(*y))?, curve.last().map(|[_, y]| short(*y))?))
        };
        if !logarithmic {
            let ((from_ms, to_ms), (from, to)) = (of(ms)?, of(|p| p.metrics.depth_p99)?);
            return Some(format!(
                "{name}: time goes from {from_ms} to {to_ms} ms over this range of {varies}, the error from {from} to {to}."
            ));
        }
        let (time, error) = (fit::slope(&curve(name, ms))?, fit::slope(&curve(name, |p| p.metrics.depth_p99)));
        let error = error.map_or(String::new(), |k| format!(", the error with {}", exponent(k)));
        Some(format!("{name}: time grows with the power {} of {varies}{error}.", exponent(time)))
    };
    names.iter().filter_map(grown).collect()
}

/// Two decimals, and no sign of a zero.
fn exponent(k: f64) -> String {
    format!("{:.2}", (100.0 * k).round() / 100.0 + 0.0)
}

/// What ours are called where the fastest stands for all.
const OURS: &str = "ours, the fastest";

/// Of each place the fastest of ours within the error at which baselines are matched, and these; none where none are.
fn within_one_error(points: &[&Point]) -> Vec<Point> {
    let matched: Vec<&Point> = points.iter().filter(|point| point.variant.is_matched()).copied().collect();
    let mut places: Vec<f64> = matched.iter().filter_map(|point| point.x).collect();
    places.dedup();
    let able = |point: &&&Point| point.variant.is_ours() && point.metrics.depth_p99 <= parts::MATCHED;
    let fastest = |x: &f64| {
        let here = points.iter().filter(able).filter(|point| point.x == Some(*x));
        let mut best: Point = (*here.min_by(|a, b| a.place()[0].total_cmp(&b.place()[0]))?).clone();
        best.variant.setting = best.variant.name();
        best.variant.technique = OURS.to_owned();
        Some(best)
    };
    let ours: Vec<Point> = places.iter().filter_map(fastest).collect();
    ours.into_iter().chain(matched.into_iter().cloned()).collect()
}

/// Who is faster within one error at each place, and where that changes.
fn at_equal_error(points: &[&Point], varies: &str) -> Vec<String> {
    let (ours, theirs): (Vec<&Point>, Vec<&Point>) =
        points.iter().copied().partition(|point| point.variant.technique == OURS);
    let mut sentences = Vec::new();
    let (mut our_curve, mut their_curve) = (Vec::new(), Vec::new());
    let mut places: Vec<(f64, &str)> =
        points.iter().filter_map(|point| Some((point.x?, point.condition.as_str()))).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    places.dedup();
    for (x, condition) in places {
        let fastest = |of: &[&Point]| -> Option<(f64, String)> {
            let here = of.iter().filter(|point| point.x == Some(x));
            let point = here.min_by(|a, b| a.place()[0].total_cmp(&b.place()[0]))?;
            let name =
                if point.variant.technique == OURS { point.variant.setting.clone() } else { point.variant.name() };
            Some((point.place()[0], name))
        };
        let verdict = match (fastest(&ours), fastest(&theirs)) {
            (Some((our_ms, our_name)), Some((ms, name))) => {
                our_curve.push([x, our_ms]);
                their_curve.push([x, ms]);
                let (who, than, more) =
                    if our_ms < ms { (our_name, name, ms / our_ms) } else { (name, our_name, our_ms / ms) };
                format!("{who} is {} times faster than {than}", short(more))
            }
            (Some((_, name)), None) => format!("only {name} is within it"),
            (None, Some((_, name))) => format!("only {name} is within it"),
            (None, None) => "nothing is within it".to_owned(),
        };
        sentences.push(format!("{varies} {condition}: {verdict}."));
    }
    sentences.push(crossovers(varies, &fit::crossings(&our_curve, &their_curve)));
    sentences
}

/// Names every place where another one becomes the faster.
fn crossovers(varies: &str, at: &[f64]) -> String {
    let places: Vec<String> = at.iter().map(|x| short(*x)).collect();
    match places.len() {
        0 => "No crossover in this range.".to_owned(),
        1 => format!("Crossover: at {varies} {}.", places[0]),
        _ => format!("Crossovers: at {varies} {}.", places.join(" and ")),
    }
}

fn embedded(shown: &Shown) -> Result<Embedded> {
    let address = |(what, picture): &(&'static str, Picture)| {
        let mut bytes = Vec::new();
        png::encode(&mut bytes, picture)
            .map_err(|e| Error::input("page", "picture", format!("cannot be encoded: {e}"), "report this as a bug"))?;
        Ok((*what, format!("data:image/png;base64,{}", STANDARD.encode(bytes))))
    };
    let pictures = shown.pictures.iter().map(address).collect::<Result<_>>()?;
    Ok(Embedded { name: shown.name.clone(), figures: shown.figures.clone(), pictures })
}

/// Text that stands in HTML as it is.
fn plain(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

const STYLE: &str = "\
body{font:15px/1.5 system-ui,sans-serif;color:#20242a;background:#fff;max-width:1560px;margin:0 auto;padding:24px}\
h1{font-size:28px}h2{font-size:21px;margin:44px 0 4px;border-top:1px solid #e2e5e9;padding-top:20px}\
p{max-width:860px}.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(560px,1fr));gap:8px}\
svg{width:100%;height:auto;display:block}\
.scroll{overflow-x:auto}table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums}\
th,td{padding:3px 10px;text-align:left;border-bottom:1px solid #eef0f2;white-space:nowrap}\
th{border-bottom:2px solid #c9ced4;position:sticky;top:0;background:#fff}\
td.wide{white-space:normal;min-width:240px}\
.MISSED{color:#b3261e;font-weight:700}.met{color:#1b7f3b}\
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(728px,100%),1fr));gap:14px 18px}\
.pictures figure{margin:0;display:flex;flex-wrap:wrap;align-content:flex-start;gap:4px 14px}\
.pictures img{width:240px;image-rendering:pixelated;display:block}\
.row{display:flex;gap:4px;flex-wrap:wrap}figcaption{font-size:13px;color:#4a5058;flex:1 1 280px}\
summary{cursor:pointer;margin:8px 0}nav a{margin-right:14px;display:inline-block}nav{line-height:2}";

/// The page.
pub fn html(about: &About, sections: &[Section], aims: &[Aim]) -> String {
    let mut page = String::new();
    let mut put = |text: String| {
        page += &text;
        page.push('\n');
    };
    put(format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Prism Shell: error against run time</title>\
         <style>{STYLE}</style></head><body>"
    ));
    put("<h1>Prism Shell: error against run time</h1>".into());
    put(format!("<p>{}</p>", plain(&about.line())));
    put(format!("<p>{}</p>", plain(METHOD)));
    if about.on_cpu {
        put(format!("<p><b>This device is a CPU.</b> {}</p>", plain(ON_CPU)));
    }
    let duels: Vec<&Section> = sections.iter().filter(|section| !section.duel.is_empty()).collect();
    let links =
        sections.iter().enumerate().map(|(i, section)| format!("<a href=\"#s{i}\">{}</a>", plain(&section.title)));
    put(format!(
        "<nav>{}{}{}</nav>",
        if aims.is_empty() { "" } else { "<a href=\"#aims\">Aims</a>" },
        if duels.is_empty() { "" } else { "<a href=\"#wins\">Where tessellation wins</a>" },
        links.collect::<String>()
    ));
    if !aims.is_empty() {
        put("<h2 id=\"aims\">Aims</h2>".into());
        put(format!("<p>{}</p>", plain(CONTESTS)));
        put(matrix(aims));
        let table = aims_table(aims);
        put(format!("<details><summary>Who competed, with times and memory</summary>{table}</details>"));
    }
    if !duels.is_empty() {
        put("<h2 id=\"wins\">Where tessellation wins</h2>".into());
        put(format!("<p>{}</p>", plain(DUELS)));
        for section in duels {
            put(format!("<h3>{}</h3>{}", plain(&section.title), list(&section.duel)));
        }
    }
    for (i, section) in sections.iter().enumerate() {
        put(format!("<h2 id=\"s{i}\">{}</h2><p>{}</p>", plain(&section.title), plain(section.text)));
        put(format!(
            "<div class=\"plots\">{}</div>",
            section.plots.iter().map(|(_, svg)| svg.as_str()).collect::<String>()
        ));
        put(list(&section.findings));
        put(pictures(&section.shown));
        put(table(section));
    }
    put("</body></html>".into());
    page
}

const METHOD: &str = "Errors are those of the surface at the same pixel centres, against a tracer in f64 that shares no code \
with what it judges. A footprint is the width of a pixel at the reference's depth. Times are GPU timestamps; all variants of \
a part are drawn in turns in one process, after frames that do not count, so that the machine's moods meet all of them alike. \
A point is the median, the thin line through it spans the quartiles, grey crosses are outliers. Errors below 1e-5 footprints \
are drawn at 1e-5. FLIP needs a shaded truth: it is the walk with the exact march, whose own depth error stands in the table, \
so that its FLIP is 0 by definition.";

const ON_CPU: &str = "Its timestamps are taken on the processor's clock while threads shade tiles: what else runs on the \
machine lengthens them, triangles cost far more in proportion than on a GPU, and texture reads are computed, not fetched. \
Ratios between shaders that do the same work hold best; orders of magnitude are not those of a GPU. The number of fragment \
shader invocations beside each time does not depend on the load.";

const CONTESTS: &str = "At equal error: of each kind of baseline the coarsest whose 99th percentile is within the error, found \
by bisection (the micro-mesh is culled in three ways, of which the fastest counts, and but for the coarsest shaded through a \
visibility buffer), against our fastest setting within the same error. The best baseline is the fastest of them; the others \
stand behind it. The spread is that of ratios within a round. Memory is all that is kept on the device, and what a baseline \
culls by on the CPU, without the colour textures.";

const DUELS: &str = "A shell pays for each pixel, and for each prism on the pixel's way; a tessellated mesh pays for each small \
triangle, but no more than its error asks. So the denser the base mesh and the smoother the map, the better for tessellation. \
Here the fastest of ours and of the baselines, all within half a footprint (99th percentile); the plots of these parts show \
both as curves.";

/// What was found of each aim, a column for each scene.
fn matrix(aims: &[Aim]) -> String {
    let (mut scenes, mut rows): (Vec<&str>, Vec<&Aim>) = (Vec::new(), Vec::new());
    for aim in aims {
        if !scenes.contains(&aim.scene.as_str()) {
            scenes.push(&aim.scene);
        }
        if !rows.iter().any(|row| row.what == aim.what) {
            rows.push(aim);
        }
    }
    let row = |row: &&Aim| {
        let cell = |scene: &&str| {
            let Some(aim) = aims.iter().find(|aim| aim.scene == *scene && aim.what == row.what) else {
                return "<td></td>".to_owned();
            };
            let ([found, _], verdict) = (cells(aim), aim.verdict());
            format!("<td class=\"{verdict}\" title=\"{}\">{found} {verdict}</td>", plain(&aim.who))
        };
        let found: String = scenes.iter().map(cell).collect();
        format!("<tr><td>{}</td><td>{}</td>{found}</tr>", plain(&row.what), plain(&row.asked))
    };
    let heads: String = scenes.iter().map(|scene| format!("<th>{}</th>", plain(scene))).collect();
    let rows: String = rows.iter().map(row).collect();
    format!("<div class=\"scroll\"><table><tr><th>what</th><th>asked</th>{heads}</tr>{rows}</table></div>")
}

fn aims_table(aims: &[Aim]) -> String {
    let mut text =
        "<div class=\"scroll\"><table><tr><th>scene</th><th>what</th><th>who</th><th>asked</th><th>found</th><th>quartiles</th>\
         <th>verdict</th></tr>"
            .to_owned();
    for aim in aims {
        let [found, spread] = cells(aim);
        let verdict = aim.verdict();
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "<tr><td>{}</td><td>{}</td><td class=\"wide\">{}</td><td>{}</td><td>{found}</td><td>{spread}</td>\
             <td class=\"{verdict}\">{verdict}</td></tr>",
            plain(&aim.scene),
            plain(&aim.what),
            plain(&aim.who),
            plain(&aim.asked)
        );
    }
    text + "</table></div>"
}

fn list(sentences: &[String]) -> String {
    let items: String = sentences.iter().map(|text| format!("<li>{}</li>", plain(text))).collect();
    format!("<ul>{items}</ul>")
}

/// What an aim found, and its quartiles.
fn cells(aim: &Aim) -> [String; 2] {
    let yes = |met| if met { "yes" } else { "no" };
    let found = match (aim.found, aim.met) {
        (Some(spread), _) => short(spread.median),
        (None, met) => met.map_or("", yes).to_owned(),
    };
    let quartiles = aim.found.filter(|s| s.low < s.high);
    [found, quartiles.map_or(String::new(), |s| format!("{} to {}", short(s.low), short(s.high)))]
}

fn pictures(shown: &[Embedded]) -> String {
    if shown.is_empty() {
        return String::new();
    }
    let figure = |shown: &Embedded| {
        let image = |(what, address): &(&str, String)| {
            format!("<img src=\"{address}\" alt=\"{}, {what}\" title=\"{what}\">", plain(&shown.name))
        };
        let images: String = shown.pictures.iter().map(image).collect();
        let whats: Vec<&str> = shown.pictures.iter().map(|(what, _)| *what).collect();
        format!(
            "<figure><div class=\"row\">{images}</div><figcaption><b>{}</b> ({}): {}</figcaption></figure>",
            plain(&shown.name),
            whats.join(", "),
            plain(&shown.figures)
        )
    };
    let figures: String = shown.iter().map(figure).collect();
    format!(
        "<details open><summary>Pictures and error maps: dark is right, a colour each power of ten of a footprint up to \
         bright yellow; green: a hole, cyan: nothing should be there</summary><div class=\"pictures\">{figures}</div></details>"
    )
}

fn table(section: &Section) -> String {
    let filled =
        |column: &&super::table::Column| section.points.iter().any(|p| (column.cell)(p).is_some_and(|c| !c.is_empty()));
    let columns: Vec<_> = FOR_PEOPLE.iter().filter(filled).collect();
    let mut text =
        format!("<details><summary>{} points</summary><div class=\"scroll\"><table><tr>", section.points.len());
    if let Some(varies) = section.varies {
        let _ = write!(text, "<th>{}</th>", plain(varies));
    }
    for column in &columns {
        let _ = write!(text, "<th title=\"{}\">{}</th>", plain(column.meaning), plain(column.head));
    }
    text += "</tr>";
    for point in &section.points {
        text += "<tr>";
        if section.varies.is_some() {
            let _ = write!(text, "<td>{}</td>", plain(&point.condition));
        }
        for column in &columns {
            let _ = write!(text, "<td>{}</td>", plain(&(column.cell)(point).unwrap_or_default()));
        }
        text += "</tr>";
    }
    text + "</table></div></details>"
}

/// The aims and crossovers for the terminal, as Markdown.
pub fn summary(about: &About, sections: &[Section], aims: &[Aim]) -> String {
    let mut text = format!(
        "{}\n\n| scene | what | who | asked | found | quartiles | verdict |\n|{}\n",
        about.line(),
        "---|".repeat(7)
    );
    for aim in aims {
        let [found, spread] = cells(aim);
        let Aim { scene, what, who, asked, .. } = aim;
        let _ = writeln!(text, "| {scene} | {what} | {who} | {asked} | {found} | {spread} | {} |", aim.verdict());
    }
    for section in sections.iter().filter(|section| !section.duel.is_empty()) {
        let _ = writeln!(text, "\n{}, within {} footprints:\n", section.title, parts::MATCHED);
        for sentence in &section.duel {
            let _ = writeln!(text, "- {sentence}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missed_figure_says_so() {
        let spread = crate::timing::Spread { low: 1.0, median: 1.5, high: 2.5 };
        let aim = Aim {
            scene: "a<b".into(),
            what: "times faster".into(),
            who: "x against y".into(),
            asked: "≥ 2".into(),
            found: Some(spread),
            met: Some(false),
        };
        let html = aims_table(std::slice::from_ref(&aim));
        assert!(html.contains("<td class=\"MISSED\">MISSED</td>") && html.contains("a&lt;b"), "{html}");
        assert!(html.contains("<td>1.50</td><td>1.00 to 2.50</td>"), "{html}");
        let rows = matrix(&[aim.clone(), Aim { scene: "c".into(), ..aim.clone() }]);
        assert_eq!(rows.matches("times faster").count(), 1, "{rows}");
        assert_eq!(rows.matches("1.50 MISSED").count(), 2, "{rows}");
        assert!(aims_table(&[Aim { met: Some(true), ..aim.clone() }]).contains(">met<"));
        assert!(aims_table(&[Aim { met: None, found: None, ..aim }]).contains("not measured"));
    }

    #[test]
    fn an_exponent_of_nothing_has_no_sign() {
        assert_eq!([-0.004, 0.004, -0.012, 1.0].map(exponent), ["0.00", "0.00", "-0.01", "1.00"]);
    }

    #[test]
    fn every_crossover_is_named() {
        assert_eq!(crossovers("base triangles", &[]), "No crossover in this range.");
        assert_eq!(crossovers("base triangles", &[130.2]), "Crossover: at base triangles 130.");
        assert_eq!(crossovers("base triangles", &[130.2, 10504.6]), "Crossovers: at base triangles 130 and 10505.");
    }

    #[test]
    fn a_file_of_ones_own_names_its_plot() {
        assert_eq!(word("/some/where/my scene.glb"), "my_scene");
        assert_eq!(word("torus"), "torus");
    }
}

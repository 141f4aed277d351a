//! The report as one HTML page that needs nothing else: words, diagrams, pictures, the whole table.

use std::fmt::Write;

use super::axis::Judge;
use super::diagram::{Point, diagram};
use super::picture::DIFFERENCE_GAIN;
use super::report::{COMMIT, Subject};
use super::sweep::Sweep;
use super::table::{COLUMNS, Table};
use super::words::{Piece, paragraphs};

const STYLE: &str = "\
:root{color-scheme:light dark;--ink:#1c2733;--soft:#5a6875;--line:#d4dbe2;--paper:#fff;--panel:#f4f6f8;--best:#0b62a8;--beaten:#8a5a12}
@media(prefers-color-scheme:dark){:root{--ink:#e6ebf0;--soft:#9aa7b4;--line:#39434e;--paper:#14191f;--panel:#1c232b;--best:#6db8f5;--beaten:#d9a557}}
*{box-sizing:border-box}body{margin:0 auto;max-width:1120px;padding:32px 24px 64px;background:var(--paper);color:var(--ink);font:16px/1.55 system-ui,'DejaVu Sans',sans-serif}
h1{font-size:1.7rem;margin:0 0 4px}h2{font-size:1.2rem;margin:40px 0 8px}p{margin:0 0 12px;max-width:78ch}.facts{color:var(--soft)}
.words b{font-weight:650;white-space:nowrap}svg{width:100%;height:auto;background:var(--panel);border-radius:6px;display:block}
.grid{stroke:var(--line);stroke-width:1}.zero{fill:var(--line);opacity:.45}.tick,.axis,.label{font:11px system-ui,'DejaVu Sans',sans-serif;fill:var(--soft)}.axis{font-size:12px}
.label{paint-order:stroke;stroke:var(--panel);stroke-width:3px;stroke-linejoin:round}.label.best{fill:var(--best);font-weight:600}.label.beaten{fill:var(--beaten)}.front{fill:none;stroke:var(--best);stroke-width:1.5;opacity:.6}
.best circle{fill:var(--best);stroke:var(--best)}.beaten circle{fill:var(--panel);stroke:var(--beaten);stroke-width:1.5}.unsure circle{stroke-dasharray:1.5 2.5;opacity:.8}
.best .interval{stroke:var(--best)}.beaten .interval{stroke:var(--beaten)}.interval{stroke-width:1.5;opacity:.55}.leader{stroke:var(--soft);stroke-width:.7;opacity:.6}
.pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(320px,1fr));gap:20px}figure{margin:0;background:var(--panel);border-radius:6px;padding:10px}
figure div{display:grid;grid-template-columns:repeat(3,1fr);gap:6px}figure img{width:100%;display:block;border-radius:3px;background:#000}
figcaption{font-size:.8rem;margin-bottom:6px;overflow-wrap:anywhere}figcaption span{color:var(--soft);display:block}
.scroll{overflow-x:auto}table{border-collapse:collapse;font-size:.78rem;font-variant-numeric:tabular-nums}
th,td{padding:3px 8px;border-bottom:1px solid var(--line);text-align:right;white-space:nowrap}th{color:var(--soft);font-weight:500}
th:first-child,td:first-child{text-align:left;position:sticky;left:0;background:var(--paper)}";

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The page.
pub fn page(sweep: &Sweep, table: &Table, subject: &Subject) -> String {
    let mut html = String::new();
    let title = escape(&format!("{}: accuracy against time", subject.model));
    let _ = writeln!(
        html,
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>{title}</title>\n<style>{STYLE}</style>\
         </head><body>\n<h1>{title}</h1>"
    );
    let _ = writeln!(html, "<p class=\"facts\">{}</p>", escape(&facts(sweep, subject)));
    words(&mut html, sweep, table);
    diagrams(&mut html, sweep, table);
    pictures(&mut html, sweep, table);
    whole_table(&mut html, table);
    html + "</body></html>\n"
}

fn facts(sweep: &Sweep, subject: &Subject) -> String {
    let adapter = subject
        .adapter
        .as_ref()
        .map_or_else(String::new, |a| format!("; {}, {}, driver {} {}", a.name, a.backend, a.driver, a.driver_info));
    let passes = subject.adapter.as_ref().map_or_else(String::new, |a| format!("; passes: {}", a.pass_timing().name()));
    let commit = COMMIT.map_or_else(String::new, |c| format!(", commit {c}"));
    let few = sweep.rows.iter().filter_map(|r| r.outcome.as_ref().ok()?.times.as_ref()).any(|t| t.samples.len() < 6);
    let few = if few {
        " Some times rest on fewer than six frames, so that their intervals hold less than 95 %; a longer --limit-seconds \
         gives more."
    } else {
        ""
    };
    format!(
        "{}×{} pixels, {}{adapter}; Pellucid {}{commit}. Layers were compared at {}×{}. {:.0} s in all{passes}.{few}",
        sweep.size[0],
        sweep.size[1],
        subject.camera,
        env!("CARGO_PKG_VERSION"),
        sweep.layer_size[0],
        sweep.layer_size[1],
        sweep.seconds
    )
}

fn words(html: &mut String, sweep: &Sweep, table: &Table) {
    html.push_str(
        "<section class=\"words\">\n<h2>In words</h2>\n<p class=\"facts\">A step is the smallest of an 8-bit channel as displayed; a pixel is \
         visibly wrong if a channel is more than one step off. FLIP is the difference that a viewer sees, from none to all. A layer's \
         links are its neighbours in the next pixels.</p>\n",
    );
    for paragraph in paragraphs(sweep, table) {
        html.push_str("<p>");
        for piece in paragraph {
            match piece {
                Piece::Text(text) => html.push_str(&escape(&text)),
                Piece::Figure(figure) => {
                    let _ = write!(html, "<b>{}</b>", escape(&figure));
                }
            }
        }
        html.push_str("</p>\n");
    }
    html.push_str("</section>\n");
}

/// The points of a diagram. Times are those over the baseline's frames beside them, which a busy machine slows down as much.
fn points(sweep: &Sweep, table: &Table, judge: Judge, error: impl Fn(usize) -> Option<f64>) -> Vec<Point> {
    (0..sweep.rows.len())
        .filter(|&i| sweep.rows[i].configuration.judge == judge)
        .filter_map(|i| {
            let time = ["relative_low", "relative_time", "relative_high"].map(|c| table.number(i, c));
            let [low, Some(middle), high] = time else { return None };
            let label = sweep.rows[i].configuration.short.clone();
            let ends = [low.unwrap_or(middle), high.unwrap_or(middle)];
            Some(Point { label, time: [ends[0], middle, ends[1]], error: error(i)?, sure: low.is_some() })
        })
        .collect()
}

fn diagrams(html: &mut String, sweep: &Sweep, table: &Table) {
    let missing = |i: usize| Some(table.number(i, "lost_percent")? + table.number(i, "merged_percent")?);
    let column = |name: &'static str| move |i: usize| table.number(i, name);
    let all = [
        (
            "Time against mean error",
            "mean error, 8-bit steps",
            points(sweep, table, Judge::Exact, column("mean_steps")),
        ),
        ("Time against FLIP", "FLIP, mean", points(sweep, table, Judge::Exact, column("flip_mean"))),
        ("Time against layers lost and merged", "layers missing, %", points(sweep, table, Judge::Exact, missing)),
        (
            "Sampling: time against mean error to many samples a pixel",
            "mean error, 8-bit steps",
            points(sweep, table, Judge::Supersampled, column("mean_steps")),
        ),
    ];
    for (title, name, points) in all.into_iter().filter(|(_, _, points)| !points.is_empty()) {
        let _ = writeln!(
            html,
            "<section><h2>{title}</h2>\n<p class=\"facts\">Times are multiples of what was asked for, drawn in turn. Down and left is better. Filled: nothing measured is both faster \
             and closer to the reference. Bars: 95 % interval of the median. Dotted: fewer than six frames, which tell little.</p>\n{}</section>",
            diagram(&points, name)
        );
    }
}

fn pictures(html: &mut String, sweep: &Sweep, table: &Table) {
    let Some(reference) = &sweep.reference_thumbnail else { return };
    let _ = writeln!(
        html,
        "<section><h2>Pictures</h2>\n<p class=\"facts\">Each: the picture, its difference to the reference {DIFFERENCE_GAIN} \
         times as large, and where its error is seen (FLIP; black is none, pale yellow is 1).</p>\n<div class=\"pictures\">\n\
         <figure><figcaption>reference<span>exact</span></figcaption><div><img alt=\"reference\" src=\"{reference}\"></div>\
         </figure>"
    );
    for (i, row) in sweep.rows.iter().enumerate() {
        let Some(t) = row.outcome.as_ref().ok().and_then(|m| m.thumbnails.as_ref()) else { continue };
        let name = escape(&row.configuration.name);
        let cell = |column| table.cell(i, column);
        let time = cell("relative_time");
        let time = if time.is_empty() { String::new() } else { format!(", {time}× the time") };
        let _ = writeln!(
            html,
            "<figure><figcaption>{name}<span>mean error {}, largest {}, FLIP {} against {}{time}</span></figcaption><div>\
             <img alt=\"{name}\" src=\"{}\"><img alt=\"difference\" src=\"{}\"><img alt=\"error\" src=\"{}\"></div></figure>",
            cell("mean_steps"),
            cell("maximum_steps"),
            cell("flip_mean"),
            match row.configuration.judge {
                Judge::Exact => "the exact picture".to_owned(),
                Judge::Supersampled => format!("{} samples", sweep.reference_samples),
            },
            t.picture,
            t.difference,
            t.heat
        );
    }
    html.push_str("</div></section>\n");
}

fn whole_table(html: &mut String, table: &Table) {
    html.push_str("<section><h2>All figures</h2>\n<div class=\"scroll\"><table><thead><tr>");
    for column in &table.columns {
        let help = COLUMNS.iter().find(|(name, _)| name == column).map_or("time of a pass", |(_, help)| help);
        let _ = write!(html, "<th title=\"{}\">{}</th>", escape(help), escape(&column.replace('_', " ")));
    }
    html.push_str("</tr></thead><tbody>\n");
    for row in &table.rows {
        html.push_str("<tr>");
        for cell in row {
            let _ = write!(html, "<td>{}</td>", escape(cell));
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody></table></div></section>\n");
}

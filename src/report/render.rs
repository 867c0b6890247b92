//! The page as one HTML file.

use anyhow::Result;
use minijinja::{Environment, context};

use super::section::Page;

/// The template; its name makes the engine escape what it inserts.
const TEMPLATE: (&str, &str) = ("page.html", include_str!("page/page.html"));
/// What the page runs, in this order, in one closure.
const SCRIPTS: [&str; 15] = [
    include_str!("page/dom.js"),
    include_str!("page/data.js"),
    include_str!("page/color.js"),
    include_str!("page/ticks.js"),
    include_str!("page/camera.js"),
    include_str!("page/lines-gl.js"),
    include_str!("page/lines-2d.js"),
    include_str!("page/layers.js"),
    include_str!("page/drawing.js"),
    include_str!("page/plot.js"),
    include_str!("page/series.js"),
    include_str!("page/worst.js"),
    include_str!("page/path.js"),
    include_str!("page/sections.js"),
    include_str!("page/main.js"),
];
const STYLE: &str = include_str!("page/page.css");
/// uPlot 1.6.32, unchanged, with its licence.
const PLOT: [&str; 3] =
    [include_str!("vendor/uPlot.iife.min.js"), include_str!("vendor/uPlot.min.css"), include_str!("vendor/LICENSE-uPlot")];

/// The page, complete: scripts, styles and data stand in it, and nothing is loaded.
///
/// # Errors
/// When it cannot be rendered.
pub fn render(page: &Page) -> Result<String> {
    let mut environment = Environment::new();
    let (name, template) = TEMPLATE;
    environment.add_template(name, template)?;
    let [plot, plot_style, plot_license] = PLOT;
    let own = format!("(() => {{\n\"use strict\";\n{}\n}})();", SCRIPTS.join("\n"));
    Ok(environment.get_template(name)?.render(context! {
        title => &page.title,
        version => env!("CARGO_PKG_VERSION"),
        style => minijinja::Value::from_safe_string(format!("{plot_style}\n{STYLE}")),
        license => minijinja::Value::from_safe_string(format!("/*\nuPlot\n{plot_license}*/")),
        plot => minijinja::Value::from_safe_string(plot.to_owned()),
        script => minijinja::Value::from_safe_string(own),
        data => minijinja::Value::from_safe_string(script_text(&serde_json::to_string(page)?)),
    })?)
}

/// JSON that may stand in a script element: nothing in it ends the element or opens a comment.
fn script_text(json: &str) -> String {
    json.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026")
}

#[cfg(test)]
mod tests {
    use super::super::section::{Content, Group, Section, Table};
    use super::*;

    fn page(text: &str) -> Page {
        let table = Content::Table(Table::new(&[text], vec![vec![text.to_owned()]]));
        let section = Section::new(text, text, table);
        Page {
            title: text.to_owned(),
            lead: text.to_owned(),
            groups: vec![Group { name: text.to_owned(), sections: vec![section] }],
        }
    }

    #[test]
    fn texts_of_a_program_stay_texts() {
        let evil = "</script><script>alert(1)</script><!-- <b>&amp;\u{2028}]]>";
        let rendered = render(&page(evil)).unwrap();
        assert!(!rendered.contains("alert(1)</script>") && !rendered.contains("<!-- <b>"));
        // The title, as text, and the elements of the template alone.
        assert!(rendered.contains("&lt;&#x2f;script&gt;") || rendered.contains("&lt;/script&gt;"));
        assert_eq!(rendered.matches("</script>").count(), render(&page("plain")).unwrap().matches("</script>").count());
        let start = rendered.find("id=\"data\">").unwrap() + "id=\"data\">".len();
        let data = &rendered[start..start + rendered[start..].find("</script>").unwrap()];
        let read: serde_json::Value = serde_json::from_str(data).unwrap();
        assert_eq!(read["groups"][0]["sections"][0]["rows"][0][0], evil);
    }

    #[test]
    fn a_page_without_data_is_small_and_loads_nothing() {
        let rendered = render(&page("plain")).unwrap();
        assert!(rendered.len() < 250_000, "{}", rendered.len());
        for loading in [" src=", "<link", "@import", "url(", "fetch(", "XMLHttpRequest", "import("] {
            assert!(!rendered.contains(loading), "{loading}");
        }
        for script in SCRIPTS {
            assert!(!script.contains("</") && script.lines().count() < 400);
        }
    }
}

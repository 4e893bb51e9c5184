//! The page's style sheet: screen in light and dark, paper in light alone.

use crate::plot::style;

/// Returns the rules of all pages. `identity` stands at the foot of every printed page; it holds
/// nothing but letters, digits, `-`, `_` and `.`.
pub(super) fn style(identity: &str) -> String {
    let light = style::variables(false);
    let dark = style::variables(true);
    let plots = style::RULES;
    let foot = foot(identity);
    format!(
        ":root{{color-scheme:light dark;{light}}}\n\
         @media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}\n\
         {PAGE}{plots}{foot}{PRINT}"
    )
}

/// Returns the rules that a report adds to those of all pages.
pub(super) fn of_report(identity: &str) -> String {
    format!("{}{REPORT}", foot(identity))
}

fn foot(identity: &str) -> String {
    format!(
        "@page{{size:A4;margin:13mm 15mm 15mm;\
         @bottom-left{{content:\"latchgate report {identity}\";font:8pt sans-serif;color:#56616c}}\
         @bottom-right{{content:\"page \" counter(page) \" of \" counter(pages);font:8pt sans-serif;color:#56616c}}}}\n"
    )
}

const PAGE: &str = "\
*{box-sizing:border-box}
html{-webkit-text-size-adjust:100%}
body{margin:0;background:var(--page);color:var(--ink);font:16px/1.5 system-ui,-apple-system,'Segoe UI',Roboto,'Helvetica Neue','DejaVu Sans',Arial,sans-serif;font-variant-numeric:tabular-nums}
main{max-width:980px;margin:24px auto;padding:30px 38px 38px;background:var(--paper);border:1px solid var(--rule);border-radius:10px}
header{display:flex;justify-content:space-between;align-items:flex-end;gap:24px;margin-bottom:18px}
header h1{font-size:20px;line-height:1.3;margin:0;font-weight:650;overflow-wrap:anywhere}
header p{margin:0;color:var(--muted);font-size:14px;overflow-wrap:anywhere}
header .id{text-align:right;flex:none;max-width:45%}
h2{font-size:18px;line-height:1.3;margin:38px 0 10px;padding-bottom:6px;border-bottom:1px solid var(--rule)}
h3{font-size:15px;margin:20px 0 6px}
p{margin:8px 0;max-width:76ch}
.note,figcaption{color:var(--muted);font-size:14px;max-width:none}
a{color:var(--first)}
code,pre{font-family:ui-monospace,SFMono-Regular,Menlo,Consolas,'DejaVu Sans Mono',monospace;font-size:13.5px}
code{overflow-wrap:anywhere}
pre{background:var(--code);border-radius:6px;padding:12px 14px;margin:8px 0;white-space:pre-wrap;overflow-wrap:anywhere}
figure{margin:14px 0 26px}
figure svg{display:block}
figcaption{margin:4px 2px 0}
.card{border:1px solid var(--tone);border-left:10px solid var(--tone);border-radius:8px;padding:20px 24px 16px;background:var(--shade)}
.pass{--tone:var(--pass)}
.fail{--tone:var(--fail)}
.undecided{--tone:var(--undecided)}
.unusable{--tone:var(--unusable)}
.answer{display:flex;align-items:center;gap:18px;color:var(--tone)}
.answer svg{flex:none;width:66px;height:66px}
.answer strong{display:block;font-size:46px;line-height:1.05;letter-spacing:.02em}
.answer span{display:block;color:var(--ink);font-size:16px}
.answer .exit{margin-left:auto;flex:none;align-self:flex-start;color:var(--muted);font-size:14px}
.key{display:grid;grid-template-columns:repeat(4,1fr);gap:14px 22px;margin:20px 0 4px}
.key div{border-top:2px solid var(--rule);padding-top:7px}
.key dt{color:var(--muted);font-size:14px}
.key dd{margin:0;font-size:14px;color:var(--muted)}
.key dd.value{font-size:21px;line-height:1.35;font-weight:650;color:var(--ink)}
.gauge{display:block;width:100%;height:auto;margin:12px 0 0}
.gauge text{font:12px system-ui,-apple-system,'Segoe UI',Roboto,'Helvetica Neue','DejaVu Sans',Arial,sans-serif;fill:var(--muted)}
.gauge .track{fill:var(--grid)}
.gauge .bar{fill:var(--tone,var(--first))}
.gauge .mark{stroke:var(--ink);stroke-width:1.25}
.gauge .limit{stroke:var(--ink);stroke-width:2.5}
.why{margin:14px 0 0;padding:0;list-style:none}
.why li{padding:6px 0;border-top:1px solid var(--rule)}
.why code{color:var(--muted);margin-left:8px;font-size:12.5px;white-space:nowrap}
.caution{margin:16px 0 -4px;font-weight:650;color:var(--tone);max-width:none}
.unusable .key dd.value{color:var(--muted)}
.sum{margin:12px 0 0;font-size:14px;color:var(--muted);max-width:none}
table{border-collapse:collapse;width:100%;margin:10px 0;font-size:14.5px}
th,td{text-align:left;vertical-align:top;padding:5px 12px 5px 0;border-bottom:1px solid var(--rule)}
th:last-child,td:last-child{padding-right:0}
thead th{color:var(--muted);font-weight:600;border-bottom:2px solid var(--rule)}
tbody th{font-weight:400}
.number{text-align:right;white-space:nowrap}
th.number{white-space:normal}
.facts th{width:31%;color:var(--muted);font-weight:400}
.facts td{overflow-wrap:anywhere}
.nominal{font-weight:650}
.above{color:var(--fail);font-weight:650}
.sides{display:grid;grid-template-columns:repeat(2,1fr);gap:0 44px;align-items:start}
.sides.three{grid-template-columns:repeat(3,1fr);gap:0 30px}
details{margin:8px 0}
summary{cursor:pointer;color:var(--first);font-size:14.5px}
.badge{display:inline-block;padding:1px 9px;border-radius:10px;border:1.5px solid currentColor;font-size:12.5px;font-weight:650;white-space:nowrap}
.badge.blocking{background:var(--fail);border-color:var(--fail);color:var(--paper)}
.badge.warning{color:var(--undecided)}
.badge.info{color:var(--muted)}
.ensembles,.inputs{font-size:14px}
.findings td:nth-child(2){overflow-wrap:anywhere}
.findings code{color:var(--muted);display:block;font-size:12.5px}
.statement{border-left:4px solid var(--rule);padding:2px 0 2px 16px}
.sign{display:grid;grid-template-columns:repeat(3,1fr);gap:0 34px;margin-top:56px}
.sign span{border-top:1px solid var(--axis);padding-top:4px;font-size:13px;color:var(--muted)}
.end{margin:34px 0 0;text-align:center;color:var(--muted);font-size:14px;max-width:none}
@media screen and (max-width:720px){
main{margin:0;padding:18px 14px;border:0;border-radius:0}
header{flex-direction:column;align-items:flex-start}
header .id{text-align:left;max-width:none}
.key{grid-template-columns:repeat(2,1fr)}
.answer strong{font-size:34px}
.answer .exit{display:none}
.sides,.sides.three{grid-template-columns:1fr}
section{overflow-x:auto}
#event .plot .muted{font-size:17px}
}
";

const PRINT: &str = "\
@media print{
*{print-color-adjust:exact;-webkit-print-color-adjust:exact}
:root{color-scheme:light}
body{background:#fff;font-size:10pt}
main{max-width:none;margin:0;padding:0;border:0;border-radius:0}
h2{font-size:12.5pt;margin:18pt 0 5pt;break-after:avoid}
h3{font-size:10.5pt;break-after:avoid}
p,pre,table{orphans:3;widows:3}
table,.note,figcaption,.sum,pre,code{font-size:8.8pt}
th,td{padding-top:2.5pt;padding-bottom:2.5pt}
figure{margin:8pt 0 12pt}
figure,.card,tr,pre,.statement,.sign,.tight{break-inside:avoid}
thead{display:table-header-group}
table{break-inside:avoid}
.findings,.impacts{break-inside:auto}
p{break-inside:avoid}
section>p:not(.note):not(.sum){break-after:avoid}
.note{break-before:avoid}
header{margin-bottom:9pt}
header p,.key dt,.key dd,.sum,.answer .exit{font-size:8.4pt}
.card{padding:10pt 14pt 8pt}
.answer{gap:12pt}
.answer svg{width:42pt;height:42pt}
.answer strong{font-size:28pt}
.answer span{font-size:10pt}
.key{margin:9pt 0 2pt;gap:8pt 14pt}
.key dd.value{font-size:13pt}
.gauge{height:auto;margin-top:4pt}
.why{margin-top:6pt;font-size:9.4pt}
.why li{padding:2.5pt 0}
.why code{font-size:7.8pt}
.sum{margin-top:5pt}
.sign{margin-top:34pt}
.end{margin-top:18pt}
details:not([open]),.live{display:none}
a{color:inherit;text-decoration:none}
}
";

/// Rules of the report alone.
const REPORT: &str = "\
main{max-width:1000px}
header{margin-bottom:12px}
.card{padding:16px 22px 12px}
.answer strong{font-size:38px}
.answer svg{width:54px;height:54px}
.answer span{font-size:17px}
.key{margin:14px 0 2px}
.key.two{grid-template-columns:repeat(2,1fr)}
.why{margin:10px 0 0;font-size:14.5px}
.why li{padding:4px 0}
#event{margin:14px 0 6px}
h2{margin:22px 0 6px;font-size:17px}
.found{margin:4px 0;padding:0;list-style:none;font-size:14.5px}
.found li{padding:3px 0}
.found code{color:var(--muted);margin-left:8px;font-size:12.5px}
#judged .facts{margin:2px 0;font-size:14px}
#judged .facts th{width:34%}
#judged .facts td,#judged .facts th{padding-top:3px;padding-bottom:3px}
#judged .sign{margin-top:44px}
#appendix{margin-top:34px}
details{border-bottom:1px solid var(--rule);margin:0;padding:7px 0}
summary{font-size:15px}
.live{display:flex;flex-wrap:wrap;gap:6px 8px;align-items:center;margin:2px 0 4px;font-size:13.5px}
.live button,.live a{font:inherit;color:var(--ink);background:var(--shade);border:1px solid var(--axis);border-radius:6px;padding:3px 9px;cursor:pointer;text-decoration:none}
.live button svg{display:inline-block;margin-right:6px;vertical-align:middle}
.live button[aria-pressed=false]{opacity:.5;text-decoration:line-through}
.live output{flex-basis:100%;min-height:3em;white-space:pre-line;font-variant-numeric:tabular-nums;color:var(--ink)}
#event>svg{touch-action:pan-y;cursor:crosshair;outline-offset:3px}
.plot .cursor{stroke:var(--ink);stroke-width:1.25}
.plot .cursor.two{stroke-dasharray:5 3}
.plot .dot{fill:var(--ink)}
@media screen and (max-width:720px){
.answer span{font-size:15px}
figure{overflow-x:auto}
details figure svg{min-width:640px}
table{font-size:12px}
th,td{white-space:normal;overflow-wrap:anywhere;padding-left:3px;padding-right:3px}
.key{grid-template-columns:repeat(2,minmax(0,1fr))}
.key dd,.answer strong{overflow-wrap:anywhere}
}
@media print{
.live{display:none}
.second,#appendix{break-before:page}
main:not(:has(details[open])) #appendix,main:not(:has(details[open])) .end{display:none}
header{margin-bottom:5pt}
header h1{font-size:12pt}
header p{font-size:8pt}
.card{padding:6pt 10pt 4pt}
.answer{gap:9pt}
.answer strong{font-size:19pt}
.answer span{font-size:9.5pt}
.answer svg{width:30pt;height:30pt}
.key{margin:5pt 0 0;gap:6pt 12pt}
.key div{padding-top:3pt}
.key dt,.key dd{font-size:7.8pt;line-height:1.35}
.key dd.value{font-size:11.5pt}
.why{margin-top:3pt;font-size:8.2pt}
.why li{padding:1pt 0}
h2{margin:7pt 0 2pt;font-size:10.5pt;padding-bottom:1.5pt}
p,.statement p{font-size:8.4pt;margin:3pt 0}
#event{margin:5pt 0 0}
#event>svg{max-height:94mm;margin:0 auto}
#event figcaption{display:none}
.found{font-size:8.2pt;margin:2pt 0}
.found li{padding:1pt 0}
.sum{margin-top:2pt}
#judged .facts,table,.ensembles,.inputs{font-size:8pt}
#judged .facts td,#judged .facts th,th,td{padding-top:1.5pt;padding-bottom:1.5pt}
#judged .sign{margin-top:22pt}
.sign span{font-size:8pt}
summary{font-weight:650;color:var(--ink);list-style:none}
}
";

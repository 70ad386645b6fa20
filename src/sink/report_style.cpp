#include "sink/report_style.h"

namespace vildar {

const std::string_view kReportStyle = R"css(
:root{--ink:#1b2430;--soft:#5b6776;--line:#dfe4ea;--paper:#fff;--panel:#f5f7f9;--accent:#1f5fa8;
--oncoming:#c76a00;--receding:#2f7fc4;--warn:#8a4b00;--warn-panel:#fff4e2;--warn-line:#f0c98f;color-scheme:light dark}
@media (prefers-color-scheme:dark){:root{--ink:#e6eaef;--soft:#9aa6b4;--line:#313b47;--paper:#12171d;--panel:#1a212a;
--accent:#7db6f2;--oncoming:#f0a040;--receding:#6cb4f0;--warn:#ffcf8a;--warn-panel:#2b2314;--warn-line:#6a5323}}
*{box-sizing:border-box}
body{margin:0;background:var(--paper);color:var(--ink);font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans",sans-serif}
main{max-width:1180px;margin:0 auto;padding:28px 24px 48px}
.brand{color:var(--soft);font-size:13px;letter-spacing:.04em;margin:0}
h1{font-size:26px;line-height:1.25;margin:2px 0 4px;overflow-wrap:anywhere}
h2{font-size:18px;margin:36px 0 10px}
p{margin:6px 0;max-width:100ch}
.soft{color:var(--soft)}
a{color:var(--accent)}
.tiles{display:flex;flex-wrap:wrap;gap:10px;margin:18px 0 0;padding:0;list-style:none}
.tiles li{flex:1 1 130px;background:var(--panel);border:1px solid var(--line);border-radius:8px;padding:10px 14px}
.tiles b{display:block;font-size:22px;line-height:1.25;font-weight:650;font-variant-numeric:tabular-nums;white-space:nowrap}
.tiles span{color:var(--soft);font-size:13px}
.warnings{background:var(--warn-panel);border:1px solid var(--warn-line);border-radius:8px;padding:12px 16px;margin:18px 0 0}
.warnings h2{font-size:15px;margin:0 0 4px;color:var(--warn)}
.warnings ul{margin:0;padding-left:18px}
.warnings li{overflow-wrap:anywhere}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:14px;font-variant-numeric:tabular-nums}
th{text-align:left;font-weight:600;color:var(--soft);font-size:12.5px;border-bottom:2px solid var(--line);padding:6px 12px 6px 0;vertical-align:bottom}
td{border-bottom:1px solid var(--line);padding:7px 12px 7px 0;vertical-align:top}
td.number,th.number{text-align:right;white-space:nowrap}
td.speed{font-weight:650;white-space:nowrap}
td.words{min-width:15em}td.short{white-space:nowrap}
tr.withheld td{color:var(--soft)}
.dot{display:inline-block;width:9px;height:9px;border-radius:50%;margin-right:7px}
.dot.oncoming{background:var(--oncoming)}.dot.receding{background:var(--receding)}
.withheld-tag{display:inline-block;border:1px solid var(--line);border-radius:4px;padding:0 6px;font-size:12.5px;white-space:nowrap}
details{border:1px solid var(--line);border-radius:8px;margin:10px 0;background:var(--paper)}
summary{cursor:pointer;padding:10px 14px;background:var(--panel);border-radius:8px}
details[open]>summary{border-bottom:1px solid var(--line);border-radius:8px 8px 0 0}
summary b{margin-right:10px}
.inside{padding:10px 14px 14px}
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,250px),1fr));gap:14px;margin:12px 0 4px}
figure{margin:0}
svg{display:block;width:100%;height:auto}
.plots svg{max-width:460px}
svg.strip{width:180px;height:18px}
svg.histogram{min-width:560px;max-width:980px}
svg text{font:12px system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans",sans-serif;fill:var(--soft)}
svg text.title{fill:var(--ink)}
.grid{stroke:var(--line);stroke-width:1}.axis{stroke:var(--soft);stroke-width:1}
.curve{fill:none;stroke:var(--accent);stroke-width:1.8;stroke-linejoin:round;stroke-linecap:round}
.whisker{stroke:var(--ink);stroke-width:1.5}.mark{fill:var(--oncoming);stroke:var(--paper);stroke-width:1}
.other-mark{fill:var(--paper);stroke:var(--ink);stroke-width:1.5}
.oncoming{fill:var(--oncoming)}.receding{fill:var(--receding)}
.interval{stroke-width:2;opacity:.55}.interval.oncoming{stroke:var(--oncoming)}.interval.receding{stroke:var(--receding)}
.limit{stroke:var(--ink);stroke-width:1.2;stroke-dasharray:5 4}
pre{overflow-x:auto;font:12.5px/1.5 ui-monospace,SFMono-Regular,Menlo,Consolas,monospace;margin:0}
code{font:12.5px ui-monospace,SFMono-Regular,Menlo,Consolas,monospace;overflow-wrap:anywhere}
.columns{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,260px),1fr));gap:8px 32px}
h3{font-size:14px;margin:10px 0 2px}
footer{margin-top:40px;border-top:1px solid var(--line);padding-top:12px;color:var(--soft);font-size:13px}
@media screen and (max-width:760px){
main{padding:18px 14px 36px}h1{font-size:21px}
table.cards,table.cards tbody{display:block}
table.cards thead{display:none}
table.cards tr{display:block;border:1px solid var(--line);border-radius:8px;padding:6px 12px;margin:0 0 10px}
table.cards td{display:flex;justify-content:space-between;gap:16px;border:0;padding:3px 0;text-align:right;white-space:normal;min-width:0}
table.cards td:empty{display:none}
table.cards td::before{content:attr(data-label);color:var(--soft);font-weight:400;text-align:left;flex:none}
}
@media print{
:root{--ink:#000;--soft:#444;--line:#ccc;--paper:#fff;--panel:#fff;--accent:#1f5fa8;--oncoming:#c76a00;--receding:#2f7fc4;
--warn:#000;--warn-panel:#fff;--warn-line:#888}
body{font-size:10.5px}main{max-width:none;padding:0}h1{font-size:19px}h2{font-size:14px;margin:20px 0 6px}.warnings h2{font-size:12px}
table{font-size:9.5px}th{font-size:9px}th,td{padding-right:7px}td.short{white-space:normal}td.words{min-width:9em}
.tiles b{font-size:14px}.tiles span,.withheld-tag,code,pre{font-size:9px}.tiles li{flex-basis:80px;padding:6px 9px}svg.strip{width:110px}
tr,figure,.tiles li{break-inside:avoid}h2,summary{break-after:avoid}.scroll{overflow:visible}
.plots{grid-template-columns:repeat(2,1fr)}
}
)css";

}  // namespace vildar

/* SPDX-License-Identifier: MIT
 *
 * A page that stands alone: no scripts, nothing from a network; reads well in light and dark, and
 * on paper.
 */
#include "analysis/table/html.h"

#include <stdarg.h>
#include <string.h>

#include "io/file/xml_text.h"

static const char style[] =
    ":root{color-scheme:light dark;--ground:#ffffff;--ink:#1c2229;--dim:#5c6773;--line:#d9dee4;"
    "--soft:#f4f6f8;--accent:#1b6f86;--warn:#fff4d6;--warnline:#e0a800;--good:#e6f4ea;"
    "--goodline:#2e8b57}\n"
    "@media (prefers-color-scheme:dark){:root{--ground:#15191e;--ink:#e4e8ec;--dim:#9aa5b1;"
    "--line:#333b44;--soft:#1d2329;--accent:#6cc3da;--warn:#3a3014;--warnline:#e0a800;"
    "--good:#16301f;--goodline:#4caf7a}}\n"
    "*{box-sizing:border-box}\n"
    "body{margin:0;background:var(--ground);color:var(--ink);"
    "font:15px/1.5 system-ui,'Segoe UI','Helvetica Neue',Arial,'DejaVu Sans',sans-serif}\n"
    "main{max-width:1120px;margin:0 auto;padding:28px 24px 60px}\n"
    "h1{font-size:28px;line-height:1.2;margin:0 0 4px}\n"
    "h2{font-size:20px;margin:44px 0 12px;padding-bottom:6px;border-bottom:2px solid "
    "var(--line)}\n"
    "h3{font-size:16px;margin:26px 0 8px}\n"
    "p{margin:8px 0}\n.dim{color:var(--dim)}\n"
    "a{color:var(--accent);text-decoration:none}\na:hover{text-decoration:underline}\n"
    "nav{display:flex;flex-wrap:wrap;gap:6px 18px;margin:14px 0 0}\n"
    ".facts{display:grid;grid-template-columns:repeat(auto-fit,minmax(150px,1fr));gap:12px;"
    "margin:22px 0}\n"
    ".facts div{background:var(--soft);border:1px solid var(--line);border-radius:8px;"
    "padding:10px 14px}\n"
    ".facts b{display:block;font-size:20px;font-variant-numeric:tabular-nums}\n"
    ".facts span{color:var(--dim);font-size:13px}\n"
    ".note{background:var(--soft);border-left:4px solid var(--line);padding:8px 14px;"
    "margin:12px 0;border-radius:0 6px 6px 0}\n"
    ".warn{background:var(--warn);border-color:var(--warnline)}\n"
    ".good{background:var(--good);border-color:var(--goodline)}\n"
    "figure{margin:14px 0;padding:10px;background:#ffffff;border:1px solid var(--line);"
    "border-radius:8px;text-align:center}\n"
    "figure svg{max-width:100%;height:auto;display:block;margin:0 auto}\n"
    ".table{overflow-x:auto}\n"
    "table{border-collapse:collapse;width:100%;font-size:14px;margin:10px 0}\n"
    "th,td{padding:5px 10px;text-align:left;border-bottom:1px solid var(--line);"
    "vertical-align:top}\n"
    "th{color:var(--dim);font-weight:600;white-space:nowrap}\n"
    "td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}\n"
    "tr.sum td{font-weight:600;border-bottom:2px solid var(--ink)}\n"
    "td.bar{width:22%;min-width:90px}\n"
    "td.bar i{display:block;height:11px;margin-top:5px;background:#4e79a7;border-radius:2px;"
    "-webkit-print-color-adjust:exact;print-color-adjust:exact}\n"
    "td.bar i.caught{background:#2b8c9e}\n"
    "code,pre{font-family:ui-monospace,'DejaVu Sans Mono',Consolas,monospace;font-size:13px}\n"
    "code{overflow-wrap:anywhere}\n"
    "pre{background:var(--soft);border:1px solid var(--line);border-radius:8px;padding:12px;"
    "overflow-x:auto;line-height:1.35}\n"
    "details summary{cursor:pointer;color:var(--accent)}\n"
    "@media print{:root{--ground:#ffffff;--ink:#000000;--dim:#444444;--line:#bbbbbb;"
    "--soft:#f4f4f4;--accent:#000000;--warn:#fff4d6;--good:#e6f4ea}"
    "main{max-width:none;padding:0}nav{display:none}body{font-size:11pt}"
    "h2,h3{break-after:avoid}figure,tr{break-inside:avoid}table{font-size:9.5pt}"
    "figure svg{max-height:230mm}}\n";

void rmap_html_text(FILE *out, const char *text)
{
    while (*text) {
        const size_t n = rmap_xml_character_nbytes((const unsigned char *)text);
        const char *entity = rmap_xml_entity(*text);
        if (entity)
            fputs(entity, out);
        else if (*text == '\n')
            fputc('\n', out);
        else if (n == 0)
            fputc('?', out);
        else
            (void)fwrite(text, 1, n, out);
        text += n ? n : 1;
    }
}

void rmap_html_printf(FILE *out, const char *format, ...)
{
    char text[1024];
    va_list args;
    va_start(args, format);
    (void)vsnprintf(text, sizeof text, format, args);
    va_end(args);
    rmap_html_text(out, text);
}

void rmap_html_begin(FILE *out, const char *title)
{
    fputs("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
          "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
          "<meta name=\"color-scheme\" content=\"light dark\">\n<title>",
          out);
    rmap_html_text(out, title);
    fprintf(out, "</title>\n<style>\n%s</style>\n</head>\n<body>\n<main>\n", style);
}

void rmap_html_end(FILE *out)
{
    fputs("</main>\n</body>\n</html>\n", out);
}

/* Where an attribute names an id; text has no bare quotes, so that none of these stands there. */
static size_t naming_nbytes(const char *at, const char *end)
{
    static const char *const naming[] = {" id=\"", "\"url(#", "href=\"#"};
    for (size_t k = 0; k < sizeof naming / sizeof *naming; k++) {
        const size_t n = strlen(naming[k]);
        if ((size_t)(end - at) > n && memcmp(at, naming[k], n) == 0)
            return n;
    }
    return 0;
}

enum rmap_status rmap_html_picture(FILE *out, struct rmap_svg *svg, int number,
                                   struct rmap_error *err)
{
    static const char head[] = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
    const char *at = NULL;
    size_t nbytes = 0;
    enum rmap_status st = rmap_svg_finish(svg, &at, &nbytes, err);
    if (st != RMAP_OK)
        return st;
    const char *end = at + nbytes;
    if (nbytes > sizeof head && memcmp(at, head, sizeof head - 1) == 0)
        at += sizeof head - 1; /* HTML knows no such line */
    while (at < end) {
        const size_t n = naming_nbytes(at, end);
        (void)fwrite(at, 1, n > 0 ? n : 1, out);
        if (n > 0)
            fprintf(out, "p%d-", number);
        at += n > 0 ? n : 1;
    }
    return RMAP_OK;
}

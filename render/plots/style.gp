# ---- the look of every plot: size in mm, 8 pt type, Okabe and Ito's colours, which any colour vision tells apart
set datafile separator ","
set encoding utf8

dark_blue = "#0072b2"
light_blue = "#b5d3e6"
dark_red = "#d55e00"
light_red = "#f3c9ab"
green = "#009e73"
purple = "#8c4f86"
orange = "#e69f00"
grey = "#606060"

# Begins a file NAME.FORMAT of a size in mm: pixels at 300 dpi, vectors in their own size on paper.
pixels(mm, dpi) = int(mm / 25.4 * dpi + 0.5)
page(name, format, width, height) = "set terminal " . ( \
  format eq "png" ? sprintf("pngcairo size %d,%d background rgb 'white' font 'DejaVu Sans,8' fontscale 3.125 linewidth 3.2", \
                            pixels(width, 300), pixels(height, 300)) : \
  format eq "pdf" ? sprintf("pdfcairo size %gcm,%gcm background rgb 'white' font 'DejaVu Sans,8' fontscale 1 linewidth 1", \
                            width / 10.0, height / 10.0) : \
  sprintf("svg size %d,%d fixed background rgb 'white' font 'DejaVu Sans,10.67' linewidth 1", \
          pixels(width, 96), pixels(height, 96))) . "; set output '" . name . "." . format . "'"

set border 3 lw 1 lc rgb "#404040"
set tics nomirror out scale 0.6,0.35 textcolor rgb "#202020"
set grid xtics ytics lt 1 lw 0.7 lc rgb "#dcdcdc"
set format "%g"
set key samplen 2 spacing 1.1 textcolor rgb "#202020"

min(a, b) = a < b ? a : b
max(a, b) = a > b ? a : b
# Axis limits with some air; a column that is constant (all zero, say) still gets a range.
low(a, b) = b > a ? a - 0.06 * (b - a) : (a == 0 ? -0.05 : a - 0.1 * abs(a))
high(a, b) = b > a ? b + 0.08 * (b - a) : (b == 0 ? 1 : b + 0.1 * abs(b))


# src/docs/doxygen.sed: comments as Doxygen reads them: no tags of HTML, no commands with a backslash.
:again
s#(///<? [^<]*)<#\1\&lt;#
t again
\#///#s#\\#\\\\#g

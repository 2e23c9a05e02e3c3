# Writes the first block of a language in README.md to a file: what the page shows must work.
#   cmake -DREADME=... -DLANGUAGE=cpp -DOUTPUT=... -P readme_block.cmake
file(READ ${README} page)
string(FIND "${page}" "```${LANGUAGE}\n" start)
string(LENGTH "```${LANGUAGE}\n" fence)
math(EXPR start "${start} + ${fence}")
string(SUBSTRING "${page}" ${start} -1 rest)
string(FIND "${rest}" "\n```" end)
string(SUBSTRING "${rest}" 0 ${end} block)
file(WRITE ${OUTPUT} "${block}\n")

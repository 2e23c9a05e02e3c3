# Writes the first block of a language in a page to a file: what the page shows must work.
#   cmake -DPAGE=... -DLANGUAGE=cpp -DOUTPUT=... -P page_block.cmake
file(READ ${PAGE} page)
string(FIND "${page}" "```${LANGUAGE}\n" start)
string(LENGTH "```${LANGUAGE}\n" fence)
math(EXPR start "${start} + ${fence}")
string(SUBSTRING "${page}" ${start} -1 rest)
string(FIND "${rest}" "\n```" end)
string(SUBSTRING "${rest}" 0 ${end} block)
file(WRITE ${OUTPUT} "${block}\n")

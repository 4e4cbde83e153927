"""The rules of check_language.py. Each rule has a pattern, 1 to 3 marks and advice."""

import collections
import re

MAX_WORDS = 25
FLAGGED_MARKS = 3

Rule = collections.namedtuple("Rule", "name marks words pattern advice")

AUX = "(?:is|are|was|were|be|do|does|did|has|have|had|must|may|can|could|will|would|should)"
BE = "(?:is|are|was|were|has|have|must|may|can|will|does|do)"
PREP = (
    "(?:of|by|in|from|to|with|at|for|on|along|without|than|before|after|about|beside|between|through|over"
    "|beyond|against|into)"
)
PRONOUN = "(?:it|them|ones?|none|this|that|these|those|both|some|others?|two|most|few|more|less|each|any|all)"
PRONOUNS = (
    "it its they them their one ones none this that these those both some other others two most few more less each"
    " any all neither rest"
)
DEMONSTRATIVE = "(?:These|Those|Both|Others?|Some|That|Neither)"
STOP = "(?:[.,;:)]|$)"


def rule(name, marks, words, pattern, advice):
    """A rule. `words`: the pattern is searched only in sentences with one of these words; "": in all."""
    return Rule(name, marks, frozenset(words.split()), re.compile(pattern), advice)


RULES = [
    rule("clause-first", 3, "what whatever who whoever whichever how that",
         r"^(?:[Ww]hat(?:ever)?|[Ww]ho(?:ever)?|Whichever)\b(?!.*\?)"
         r"|^How (?!to\b|many \w+ (?:to \w+|\w+ \w+)\.?$)(?!.*\?)"
         r"|^That (?:an?|the|all|each|every|no|it|they)\b",
         "begin with a noun or a verb"),
    rule("where-for-if", 3, "where wherever",
         r"^Where(?:ver)? (?!to\b|available\b|\w{1,2} |\S*[_\\\d])",
         "write `if` for a condition, and the noun for a place"),
    rule("clause-as-noun", 3, "what whatever whoever who thing things something anything nothing everything",
         r"(?<!^)(?<!matter )(?<!regardless of )\b(?:what(?:ever)?|whoever)\b"
         r"(?! (?:to|we|you|happens|kind|type|parts?|if|the (?:user|caller))\b)"
         r"|\b(?:and|or|but|of|to|by|with|than|for|if|all) who\b|thing[s]? (?:that|which)\b",
         "name the thing with a noun"),
    rule("of-first", 3, "of",
         r"^Of (?!course\b)|^of (?:which|whom|these|those)\b|[:;] of (?!the |an? )\w+ ",
         "begin with the subject"),
    rule("preposition-first", 3, "by from along against beside",
         r"^(?:By|From|Along|Against|Beside) (?!(?:default|convention|definition|design|here|there|now|scratch"
         r"|this|virtue|\w+ing)\b|the way\b)(?![^,]*, (?:we|you|the|this|it|an?)\b)",
         "begin with the subject"),
    rule("inversion", 3, "nor neither so is are was were",
         rf"\b(?:nor|neither) {BE} (?:the|an?|its?|their|they|th[eo]se|that|all|one|what|much|\w+s)\b"
         rf"|(?:\band |[,;] |^)[Ss]o {BE} (?:the|an?|its?|their|they|th[eo]se|that|all|one|what|much|\w+s)\b"
         r"|^(?:Not |Never )?(?!Children)(?:[Tt]old|[Kk]ept|[Ll]eft|[Vv]alid|\w+(?:ed|en|wn|eld|und))"
         r" (?:is|are|was|were) (?!out\b)",
         "write subject, verb, object"),
    rule("but-for", 3, "but",
         r"\bbut for\b(?! \w+ \w+(?: \w+)?, )|\ball but\b|\bbut (?:of|those|that of)\b",
         "write `except`"),
    rule("from-on", 3, "on",
         rf"\bfrom\b[^,.;]{{1,40}} on(?:{STOP}| {AUX}\b)",
         "write `starting with` or `after`"),
    rule("open-quantity", 3, "so as",
         r"\bso (?:many|much|few|little|long|large|often|seldom|late)\b(?! (?:as|that)\b)"
         r"|(?<!least )(?<!most )\bas (?:many|much|few|little|often) (?!as\b|possible\b|of\b)\w+ (?!\w* ?as\b)",
         "name the number"),
    rule("same-of", 3, "same likewise",
         r"\bthe same (?:of|but)\b|^[Tt]he same (?:of|but|for|with|in|as|at)\b|\blikewise\b",
         "repeat the noun"),
    rule("headless-adjective", 3, "the",
         r"\b[Tt]he (?:last|first|second|next|former|others?|rest|nearest|newest|older|newer|smaller|larger)"
         rf"(?: of (?:the )?\w+)?(?:{STOP}| {AUX}\b)",
         "repeat the noun"),
    rule("bare-decimal", 3, "", r"(?<![\w.)\]/*%`])\.\d", "write the leading zero"),
    rule("pronoun-with-clause", 2, "that which who whom whose",
         r"\b(?i:that|those|all|others?|any|data|parts?) (?:that|which|who|whom|whose)\b(?! is\b)",
         "write the noun"),
    rule("possessive-without-noun", 2, "",
         r"(?<!\bit)(?<!\bthat)(?<!\blet)(?<!here)(?<!\bwhat)(?<!\bwho)'s"
         rf"(?={STOP}| (?:only|alone|as|if|where|and|or|which|too|both|when|but|{AUX}|{PREP})\b)",
         "repeat the noun"),
    rule("unfinished-clause", 2,
         "is are was were be do does did has have had must may can could will would should",
         rf"(?<!to )\b{AUX}(?: not)?(?:[.;](?: |$)|$|, (?!but\b|and\b|or\b|e))",
         "finish the clause"),
    rule("as-clause", 2, "as",
         rf"\bas \w+ (?:{AUX}|says?|takes?|tells?|gives?|comes?|stands?|made|saw|sees|found)"
         rf"(?: (?:it|them|that|so|now|there))?(?:{STOP}| (?:in|on|at|by)\b)|^As (?:if|\w+ \w+ (?:it|them))\b",
         "write a separate sentence"),
    rule("pronoun-first", 2, PRONOUNS,
         rf"^{DEMONSTRATIVE}(?:,|$| (?:{AUX}|of|to)\b)|^(?:[Ii]t|[Tt]hey|[Ii]ts|[Tt]heir)\b"
         r"|^[Tt]he (?:others?|rest)\b",
         "begin with the noun"),
    rule("speech-verb", 2, "tell tells told say says said speak speaks asks asked",
         r"\b(?:tells?|told|says?|said|speaks?|(?<!user )(?<!caller )ask(?:s|ed))\b",
         "write `contains`, `reports`, `logs` or `determines`"),
    rule("late-adverb", 2, "all turn once too either otherwise that both alone meanwhile anew thereof",
         rf", (?:in all|in turn|at once|too|either|otherwise|that is|both|alone){STOP}"
         r"|\b(?:meanwhile|anew|thereof)\b",
         "put the adverb in front of the verb"),
    rule("private-word", 2,
         "found find finds afar astray numbers doubles feigns feigned saw see sees go goes held leaves leave left"
         " way",
         r"\bfinds? again\b|\bfound again\b|\bfrom afar\b|\bled astray\b|\b(?:own|few) numbers\b|\bdoubles\b"
         r"|\bfeign(?:s|ed)\b|\b(?:saw|sees?) through\b|\bgoes? by\b|\b(?:poorly|loosely) held\b"
         r"|\bheld (?:poorly|loosely|least)\b|\b(?:leaves?|left) (?:\w+ )?(?:free|open)\b"
         r"|\bthe way (?:of|between|over)\b",
         "write the term of the field"),
    rule("bare-pronoun", 1, PRONOUNS,
         rf"(?i:\b{PREP}) {PRONOUN}(?:{STOP}| (?:is|are|has|have)\b)|\b(?:those|that|these) of\b",
         "repeat the noun"),
    rule("as-given", 1, "as", r"\bas (?:it|they|given|if|far|read|measured|kept)\b", "name the value"),
    rule("nothing", 1, "nothing nobody none", r"\b(?:nothing|nobody|none)\b", "name the empty value"),
    rule("of-which", 1, "which whom", rf"\b{PREP} wh(?:ich|om)\b", "write two sentences"),
    rule("stranded-preposition", 1, "by from with of to on at for against through over",
         r"\b(?:by|from|with|of|to|on|at|for|against|through|over)(?:[.;:]|$)",
         "put the preposition in front of its noun"),
    rule("where", 1, "where wherever whenever that",
         r"(?<!^)\b(?:where|wherever|whenever)\b|\bso that\b.*\bthat\b",
         "write `if` or `when`"),
    rule("the-one", 1, "one ones such",
         r"\b(?:the|another|this|that|other|each|every|which|\w+er|\w+est) ones?\b"
         r"|\bsuch (?:ones?\b|an? (?!way\b|case\b|manner\b|situation\b))",
         "repeat the noun"),
    rule("posture-verb", 1, "held stand stands stood lie lies come comes came go goes went gone",
         r"\b(?:held|stands?|stood|lies?|comes?|came|goes|went|gone)\b",
         "write `is`, `contains` or `follows`"),
]

RELATIVE = frozenset("that which who whom whose what where whatever wherever when as if".split())
ADVICE = {
    **{rule.name: rule.advice for rule in RULES},
    "stacked-clauses": "use at most one relative clause",
    "long": f"split sentences of more than {MAX_WORDS} words",
}
CODE = re.compile(r"`[^`]*`|https?://\S+")
COUNTED_WORD = re.compile(r"(?<!\S)[\"'(\[]*(?:[a-z][a-z'_-]+|a|`code`)[\"')\].,;:!?]*(?!\S)", re.I)  # no formulas


def broken_rules(text, follows=False):
    """The names of the rules that a sentence breaks, with their marks.

    `follows` permits a pronoun as the first word: the sentence before has its noun.
    """
    text = CODE.sub("`code`", text)
    text = text[0] + text[1:].replace("None", "`None`").lower()
    words = re.findall(r"[a-z']+", text.lower())
    present = set(words)
    broken = {}
    for name, marks, required, pattern, _ in RULES:
        if required and required.isdisjoint(present):
            continue
        if pattern.search(text) and not (follows and name == "pronoun-first"):
            broken[name] = marks
    relatives = sum(word in RELATIVE for word in words)
    if relatives >= 2 and relatives > 0.12 * len(words) or relatives >= 4 and relatives > 0.09 * len(words):
        broken["stacked-clauses"] = 1
    if len(text.split()) > MAX_WORDS and len(COUNTED_WORD.findall(text)) > MAX_WORDS:
        broken["long"] = 3
    return broken


def is_flagged(broken):
    """True if the marks of the broken rules are too many."""
    return sum(broken.values()) >= FLAGGED_MARKS

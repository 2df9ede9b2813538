"""Common parts of passwords: frequent words, and runs of neighbouring keys.

The words are those that lists of leaked passwords have in common, and those that a hospital uses
for this machine. [assumed]
"""

_LISTED = """
abc123 access admin administrator alexander amanda andrea andrew angel anthony apple april
arsenal ashley august austin autumn babygirl bailey banana barcelona baseball basketball batman
bedside blahblah bonjour buster butterfly calvin catheter change changeit changeme charlie
cheese chelsea chocolate clinic clinician computer cookie daniel december default demo diamond
doctor dragon easter engineer england family february flower football forever freedom friday
friend geheim ginger google guest hallo hammer hannah happy harley health heather hello hockey
hospital hunter iloveyou inspiron intensive internet january jasmine jennifer jessica jordan
joshua july june justin killer letmein liverpool login london lovely maggie manager march
martin master matrix matthew maverick medical medicine melissa mercedes michael michelle mickey
midnight minecraft monday monkey monster morgan mustang mylove naruto nicole night november
nurse nursing observer october office oliver orange panther parola pass passe passord passwd
passwort password patient patrick peanut pepper phoenix physician please pokemon porsche
princess private pussy rabbit ranger robert root samantha saturday scooter secret security
senha september server service shadow silver slipknot soccer spring star starwars start student
suction summer sunday sunshine superman support system taylor temp tennis test testing thomas
thunder thursday tigger trachea tracheal trustno trustnoone tuesday user vacuum ventilator ward
wednesday welcome whatever wilkommen willkommen william winter wizard yankees yellow
"""
WORDS = frozenset(_LISTED.split())
RUNS = (
    "abcdefghijklmnopqrstuvwxyz",
    "01234567890",
    "qwertyuiop",
    "qwertzuiop",
    "azertyuiop",
    "asdfghjkl",
    "qsdfghjklm",
    "zxcvbnm",
    "yxcvbnm",
    "1q2w3e4r5t6y7u8i9o0p",
    "qazwsxedcrfvtgbyhnujmikolp",
    "1qaz2wsx3edc4rfv5tgb6yhn7ujm8ik9ol0p",
)
"""In either direction."""
SHORTEST_RUN = 3

LOOKALIKES = str.maketrans("013457@$!€", "oieastasie")
"""What is written for a letter."""

import sys
from PIL import Image
out,w,cols,*names=sys.argv[1:]; w=int(w); cols=int(cols)
ims=[Image.open(n).convert('RGB') for n in names]; ims=[i.resize((w,round(i.height*w/i.width)),Image.LANCZOS) for i in ims]
rows=[ims[i:i+cols] for i in range(0,len(ims),cols)]
H=sum(max(i.height for i in r)+8 for r in rows); o=Image.new('RGB',(cols*(w+8),H),'magenta'); y=0
for r in rows:
    for k,i in enumerate(r): o.paste(i,(k*(w+8),y))
    y+=max(i.height for i in r)+8
o.save(out)
